#include "compare/samples/sample_file.h"

#include <fmt/format.h>

#include <string>

#include "compare/files/zip_entries.h"
#include "phase/stack/stack_file.h"
#include "phase/stack/stack_paths.h"

namespace lamella {
namespace {

std::vector<GrowingNpz::Column> columns_of(int channels) {
  const auto width = static_cast<std::uint64_t>(channels);
  return {{"w_i", "<f4", "3", 12},
          {"w_o", "<f4", "3", 12},
          {"weight", "<f4", fmt::format("{}", channels), 4 * width},
          {"order", "<u4", "", 4},
          {"side", "|i1", "", 1}};
}

template <class T>
std::string npy(const char* type, const std::string& shape, const std::vector<T>& values) {
  return npy_header(type, shape) +
         std::string(reinterpret_cast<const char*>(values.data()), values.size() * sizeof(T));
}

}  // namespace

SampleFile::SampleFile(const std::filesystem::path& path, int channels)
    : path_(path), file_(path, columns_of(channels)) {}

void SampleFile::add(const SampleChunk& chunk) {
  for (int k = 0; k < kSampleColumns; ++k)
    file_.append(k, column_bytes(chunk.samples, k), chunk.checksums[k]);
}

void SampleFile::add(const WalkSamples& samples) {
  for (int k = 0; k < kSampleColumns; ++k) {
    const std::string_view bytes = column_bytes(samples, k);
    file_.append(k, bytes, checksum(bytes));
  }
}

std::uint64_t SampleFile::finish(const SampleRequest& request,
                                 const std::vector<SampleTotals>& totals,
                                 const InputFiles& inputs) {
  std::vector<double> directions;
  std::vector<std::uint64_t> walks, rows, all(1);
  for (const SampleTotals& one : totals) {
    all[0] += one.walks;
    if (request.law != IncidentLaw::fixed) continue;
    directions.insert(directions.end(), {one.incident.x, one.incident.y, one.incident.z});
    walks.push_back(one.walks);
    rows.push_back(one.rows);
  }
  const std::string count = fmt::format("({},)", walks.size());
  return file_.finish(
      {{"walks", npy("<u8", "()", all)},
       {"directions", npy("<f8", fmt::format("({}, 3)", walks.size()), directions)},
       {"direction_walks", npy("<u8", count, walks)},
       {"direction_rows", npy("<u8", count, rows)},
       {"lamella", npy_text(samples_about(request, inputs, path_.parent_path()).dump())}});
}

nlohmann::ordered_json samples_about(const SampleRequest& request, const InputFiles& inputs,
                                     const std::filesystem::path& folder) {
  const TruthRequest& truth = request.truth;
  const Plan& plan = request.plan;
  nlohmann::ordered_json about{{"version", LAMELLA_VERSION},
                               {"stack", to_toml(with_files_relative_to(truth.stack, folder))},
                               {"w_i", to_text(request.law)},
                               {"walks", truth.effort.walks},
                               {"seed", truth.seed},
                               {"isa", to_text(truth.isa)},
                               {"max_order", plan.max_order},
                               {"thinned_from", plan.thinning.first}};
  if (!inputs.empty()) about["files"] = inputs.text(folder);
  return about;
}

}  // namespace lamella
