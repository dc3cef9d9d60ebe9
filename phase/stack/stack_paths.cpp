#include "phase/stack/stack_paths.h"

namespace lamella {

namespace fs = std::filesystem;

bool is_file(const GridReference& grid) { return !grid.file.starts_with("builtin:"); }

fs::path path_of(const GridReference& grid) { return fs::path(grid.folder) / grid.file; }

std::vector<fs::path> files_of(const Stack& stack) {
  std::vector<fs::path> files;
  for (const Layer& layer : stack.layers)
    if (layer.grid && is_file(*layer.grid)) files.push_back(path_of(*layer.grid));
  return files;
}

fs::path relative_to(const fs::path& file, const fs::path& folder) {
  const fs::path from = fs::weakly_canonical(fs::absolute(folder.empty() ? "." : folder));
  const fs::path parent = fs::weakly_canonical(fs::absolute(file).parent_path());
  return (parent.lexically_relative(from) / file.filename()).lexically_normal();
}

Stack with_files_relative_to(Stack stack, const fs::path& folder) {
  for (Layer& layer : stack.layers)
    if (layer.grid && is_file(*layer.grid)) {
      layer.grid->file = relative_to(path_of(*layer.grid), folder).string();
      layer.grid->folder = folder.string();
    }
  return stack;
}

}  // namespace lamella
