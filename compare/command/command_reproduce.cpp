#include <fmt/format.h>

#include <algorithm>

#include "compare/command/command.h"
#include "compare/command/picture_options.h"
#include "compare/files/folder_lock.h"
#include "compare/files/output_folder.h"
#include "compare/options/progress.h"
#include "compare/report/json_report.h"
#include "compare/report/wrapped_text.h"
#include "compare/reproduce/reproduction.h"
#include "compare/request/errors.h"
#include "compare/request/interrupt.h"
#include "volume/grains/grain_scene.h"

namespace lamella {
namespace {

using Json = nlohmann::ordered_json;

std::vector<Reproduction> with_more(std::vector<Reproduction> list,
                                    const std::vector<Reproduction>& more) {
  list.insert(list.end(), more.begin(), more.end());
  return list;
}

}  // namespace

const std::vector<Reproduction>& reproductions() {
  static const std::vector<Reproduction> list = with_more(
      {
          {"vmf_figure_5",
           "successively smaller spheres in a slab of one thickness, for two packings: the error "
           "of "
           "vmf_diffuse falls to that of the medium",
           "d'Eon and Weidlich 2024, VMF Diffuse, figure 5", 400000, true, reproduce_vmf_figure_5},
          {"vmf_figure_6",
           "slices of the hemisphere, first and second bounce: a deep sphere bed, vmf_diffuse at r "
           "= "
           "0.4, a Beckmann height field at alpha = 1.4",
           "d'Eon and Weidlich 2024, VMF Diffuse, figure 6", 400000, true, reproduce_vmf_figure_6},
          {"lambert_sphere_dilute",
           "a deep bed of Lambertian spheres approaches the Lambert-sphere medium and its BRDF as "
           "the "
           "volume fraction falls",
           "d'Eon 2021, Lambert-sphere BRDF, figures 1 and 12", 1000000, true,
           reproduce_lambert_sphere_dilute},
          {"micrograin_figure_4", "distances to the closest grain, and the filling factor",
           "Lucas et al. 2023, Micrograin BSDF, figure 4", 1000000, true,
           reproduce_micrograin_figure_4},
          {"micrograin_figure_5", "distribution of the grains' normals",
           "Lucas et al. 2023, Micrograin BSDF, figure 5", 1000000, true,
           reproduce_micrograin_figure_5},
          {"micrograin_figure_9", "visible filling factor",
           "Lucas et al. 2023, Micrograin BSDF, figure 9", 1000000, true,
           reproduce_micrograin_figure_9},
          {"vmf_figure_9",
           "spheres of vMF flakes under a dielectric coat and bare, over the flakes' roughness: by "
           "the "
           "solver, by walks and by closed forms",
           "d'Eon and Weidlich 2024, VMF Diffuse, figure 9", 20000, false, reproduce_vmf_figure_9},
          {"lambert_sphere_figure_13",
           "a rough coat over Lambert's law, Lambert spheres (the medium and its BRDF) and "
           "Henyey-Greenstein: by the solver, by walks and by closed forms",
           "d'Eon 2021, Lambert-sphere BRDF, figure 13", 20000, false,
           reproduce_lambert_sphere_figure_13},
          {"spongecake_figure_14",
           "a half space of SGGX mirrors in single scattering, doubled, against microfacets",
           "Wang et al. 2022, SpongeCake, figure 14", 1, false, reproduce_spongecake_figure_14},
          {"spongecake_figure_16",
           "sheen: a layer of SGGX fibers that stand up against Conty and Kulla's facets",
           "Wang et al. 2022, SpongeCake, figure 16", 1, false, reproduce_spongecake_figure_16},
      },
      spongecake_lobe_figures());
  return list;
}

int reproduce_command(const Options& options, const std::string& name,
                      const std::vector<std::string>& pictures) {
  std::FILE* out = table_stream(options);
  const auto& list = reproductions();
  Json answer = json_header("reproduce", options.seed, isa_of(options));
  if (name.empty()) {
    answer["reproductions"] = Json::array();
    for (const Reproduction& r : list) {
      if (!options.quiet)
        fmt::print(out, "{}{}", wrapped(fmt::format("{:<24} ", r.name), r.doc),
                   wrapped(std::string(25, ' '), r.source));
      answer["reproductions"].push_back({{"name", r.name}, {"doc", r.doc}, {"source", r.source}});
    }
    write_json(answer, options.json);
    return kDone;
  }
  const auto found =
      std::find_if(list.begin(), list.end(), [&](const Reproduction& r) { return r.name == name; });
  if (found == list.end()) {
    std::vector<std::string> names;
    for (const Reproduction& r : list) names.push_back(r.name);
    const std::string hint = suggestion(name, names);
    throw UsageError(fmt::format("reproduction \"{}\": unknown{}; allowed: {}", name,
                                 hint.empty() ? "" : ", " + hint, listed(names)));
  }
  if (found->has_grains) GrainScene::require_available();
  ReproductionContext context{.seed = options.seed,
                              .stop = &user_interrupt,
                              .table = options.quiet ? nullptr : out,
                              .folder = options.output.empty() ? name : options.output,
                              .formats = picture_formats_of(pictures),
                              .walks = options.walks_given ? options.walks : found->walks};
  make_output_folder(context.folder);
  const FolderLock lock(context.folder);
  if (context.table)
    fmt::print(out, "{}{}\n", wrapped(found->name + ": ", found->source, 4),
               wrapped("", found->doc));
  catch_interrupts();
  answer["name"] = name;
  answer["source"] = found->source;
  answer["walks"] = context.walks;
  answer["rows"] = found->run(context);
  answer["pictures"] = context.pictures;
  if (context.table) {
    if (context.formats.empty()) {
      fmt::print(out, "\n{}", absent_pictures_text());
    } else {
      fmt::print(out, "\n{}",
                 wrapped(fmt::format("wrote {}/: ", context.folder),
                         fmt::format("{}", fmt::join(context.pictures, " ")), 4));
    }
  }
  write_json(answer, options.json);
  return kDone;
}

}  // namespace lamella
