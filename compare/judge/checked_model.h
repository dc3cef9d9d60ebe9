#pragma once

#include <string>

#include "analytic/model/model.h"

namespace lamella {

/// A model under check, its parameters fixed.
struct CheckedModel {
  const Model& model;
  std::string request;  ///< as --model takes it: named in findings
  int lobes = 1;
  bool reciprocal = true, transmits = false;
  bool single_precision = false;  ///< every value is a number of single precision
};

}  // namespace lamella
