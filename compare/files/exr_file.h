#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "compare/files/exr_image.h"
#include "compare/files/output_folder.h"

namespace lamella {

/// Writes a single-part scan-line file, float32, ZIP. The file sorts its channels by name, and
/// holds neither time nor path: images with equal channels and attributes give equal bytes. Atomic
/// (see write_file). Throws OutputError, also for a value that is not finite, a channel of the
/// wrong size, a name used twice, or an attribute that has the name of one of EXR's own.
void write_exr(const std::filesystem::path& path, const ExrImage& image);

/// Reads the first part of a file back, channels in the file's order; attributes other than strings
/// are left out. Throws OutputError. Other parts: exr_parts.h.
[[nodiscard]] ExrImage read_exr(const std::filesystem::path& path);

/// Doubles as a channel's floats. Throws OutputError where one is not finite or beyond float's
/// range; numbers below float's range become 0.
[[nodiscard]] std::vector<float> exr_values(std::span<const double> values);

/// "wi0.reflect.order1.se.R": the place of a channel in a file of lobes.
///   side: "reflect" or "transmit"; lobe: "all", "order1" ... "order3", "order4plus", or a closed
///   form's own; part: "" for the value itself, else "se", "truth", "model", "difference" or "z";
///   channel: "R", "G", "B" or, for grey, "Y".
[[nodiscard]] std::string channel_name(int direction, std::string_view side, std::string_view lobe,
                                       std::string_view part, std::string_view channel);

/// Copies wi0.reflect.all.R, G, B (or Y) to plain R, G, B (or Y), which viewers show. They sort
/// before the lower-case layers. Channels that are not there, or are there already, are left alone.
void add_plain_channels(ExrImage& image);

}  // namespace lamella
