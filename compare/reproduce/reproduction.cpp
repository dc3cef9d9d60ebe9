#include "compare/reproduce/reproduction.h"

#include <filesystem>

namespace lamella {

void ReproductionContext::write(const std::string& name, const Chart& chart) {
  write(name, [&](PictureFormat format) { return draw_chart(chart, format); });
}

void ReproductionContext::write(const std::string& name,
                                const std::function<std::string(PictureFormat)>& draw) {
  for (const std::string& path : write_pictures(folder + "/" + name, formats, draw))
    pictures.push_back(std::filesystem::path(path).filename().string());
}

}  // namespace lamella
