#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "compare/exchange/tensor_brdf.h"
#include "compare/request/model_request.h"

namespace lamella {

/// A reflection that a format of measured materials is written from.
struct ExportedBrdf {
  BsdfFunction f;
  bool isotropic = true;
  std::string description;  ///< one line for people, kept in the file where it has a place
  std::vector<std::string> left_out;  ///< what no such format holds, one line each
};

/// The same of a closed form, which must outlive the result. Whether it is isotropic is found by
/// asking for values at turned pairs.
[[nodiscard]] ExportedBrdf exported_model(const BoundModel& model);

enum class BrdfFormat { mitsuba, pbrt, merl };

/// "mitsuba", "pbrt", "merl"; nothing for any other text.
[[nodiscard]] std::optional<BrdfFormat> parse_brdf_format(const std::string& text);

/// Nodes of a tensor file by name: "small", "medium", "large" (8, 16, 32 angles of incidence).
[[nodiscard]] TensorSize tensor_size(const std::string& name);

/// The file's bytes. Throws std::invalid_argument where the format cannot hold it: MERL of an
/// anisotropic one.
[[nodiscard]] std::string brdf_bytes(const ExportedBrdf& source, BrdfFormat format,
                                     const TensorSize& size);

/// A measured material as a closed form with one lobe, "measured", from a MERL file or a tensor
/// file, told apart by their content. Throws FormatError.
[[nodiscard]] std::unique_ptr<Model> read_brdf(const std::string& bytes, const std::string& file);

/// What is known of it, and a model with that.
[[nodiscard]] ModelInfo measured_info(const std::string& name);

/// The error of a format, as `compare` has errors: the relative RMSE of a lobe on cells, colours
/// together, over 8 incident directions along mu_i^2 with 8 x 16 cells each, a cell's mean being
/// that of 4 x 4 points. `read`: what a reader of the file gets.
[[nodiscard]] double format_error(const ExportedBrdf& source, const Model& read);
inline constexpr int kErrorDirections = 8, kErrorRows = 8, kErrorColumns = 16, kErrorPoints = 4;

}  // namespace lamella
