#include "compare/reproduce/vmf_figures.h"

namespace lamella {

std::vector<Reproduction> vmf_figures() {
  const auto source = [](const char* place) {
    return std::string("d'Eon and Weidlich 2024, VMF Diffuse, ") + place;
  };
  return {
      {"vmf_figure_1", "sand lit from the front, the side and the back", source("figure 1"), 1,
       false, reproduce_vmf_figure_1},
      {"vmf_figure_2",
       "beds of spheres of one number density and growing radius, from porous to a height field, "
       "and the roughness that stands for each",
       source("figure 2"), 300000, true, reproduce_vmf_figure_2},
      {"vmf_figure_3",
       "energy of every order over albedo and roughness: by the solver and by the four lobes",
       source("figure 3"), 1, false, reproduce_vmf_figure_3},
      {"vmf_figure_4", "Fourier components of order 1 at 13 roughnesses: truth, fit, error",
       source("figure 4"), 1, false, reproduce_vmf_figure_4},
      {"vmf_figure_5",
       "successively smaller spheres in a slab of one thickness, for two packings: the error of "
       "vmf_diffuse falls to that of the medium",
       source("figure 5"), 400000, true, reproduce_vmf_figure_5},
      {"vmf_figure_6",
       "slices of the hemisphere, first and second bounce: a deep sphere bed, vmf_diffuse at r = "
       "0.4, a Beckmann height field at alpha = 1.4",
       source("figure 6"), 400000, true, reproduce_vmf_figure_6},
      {"vmf_figure_7",
       "spheres in white light whose roughness goes around them, with the albedo and with the "
       "remapped albedo",
       source("figure 7"), 1, false, reproduce_vmf_figure_7},
      {"vmf_figure_8", "a sphere with a texture of roughness under a lamp that turns around it",
       source("figure 8"), 1, false, reproduce_vmf_figure_8},
      {"vmf_figure_9",
       "spheres of vMF flakes under a dielectric coat and bare, over the flakes' roughness: by the "
       "solver, by walks and by closed forms",
       source("figure 9"), 20000, false, reproduce_vmf_figure_9},
      {"vmf_figure_10",
       "Oren-Nayar, vmf_diffuse and vmf_diffuse with the remapped albedo over the roughness",
       source("figure 10"), 1, false, reproduce_vmf_figure_10},
      {"vmf_figure_11", "Fourier components of order 2 at 13 roughnesses: truth, fit, error",
       source("figure 11"), 1, false, reproduce_vmf_figure_11},
      {"vmf_figure_12", "Fourier components of order 3 at 13 roughnesses: truth, fit, error",
       source("figure 12"), 1, false, reproduce_vmf_figure_12},
  };
}

}  // namespace lamella
