#include "phase/medium/medium.h"

namespace lamella {

double sigma(const Medium& medium, Direction w) {
  return std::visit([&](const auto& m) { return m.sigma(w); }, medium);
}

PhaseValue phase(const Medium& medium, Direction wi, Direction wo) {
  return std::visit([&](const auto& m) { return m.phase(wi, wo); }, medium);
}

bool is_delta(const Medium& medium) {
  return std::visit([](const auto& m) { return m.is_delta(); }, medium);
}

MediumTraits traits(const Medium& medium) {
  return std::visit([](const auto& m) { return m.traits(); }, medium);
}

double largest_density(const Medium& medium) {
  return std::visit([](const auto& m) { return m.largest_density(); }, medium);
}

}  // namespace lamella
