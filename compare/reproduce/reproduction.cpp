#include "compare/reproduce/reproduction.h"

#include <filesystem>

namespace lamella {

void ReproductionContext::write(const std::string& name, const Chart& chart) {
  const auto draw = [&](PictureFormat format) { return draw_chart(chart, format); };
  for (const std::string& path : write_pictures(folder + "/" + name, formats, draw))
    pictures.push_back(std::filesystem::path(path).filename().string());
}

}  // namespace lamella
