#include "phase/stack/stack_paths.h"

#include <gtest/gtest.h>

#include "phase/stack/stack_file.h"

namespace lamella {
namespace {

namespace fs = std::filesystem;

Stack with_grid(const std::string& grid, const std::string& file) {
  return parse_stack("[[layer]]\nmedium = \"henyey_greenstein\"\nthickness = 1\ngrid = \"" + grid +
                         "\"\nsize = [1, 1]\n",
                     file, "cloth");
}

TEST(StackPaths, AGridIsNamedFromTheFolderOfTheTextThatNamesIt) {
  const Stack stack = with_grid("c.vdb", "in/cloth.toml");
  EXPECT_EQ(path_of(*stack.layers[0].grid), "in/c.vdb");
  const std::pair<const char*, const char*> cases[] = {{"in", "c.vdb"},
                                                       {"", "in/c.vdb"},
                                                       {".", "in/c.vdb"},
                                                       {"out", "../in/c.vdb"},
                                                       {"out/points", "../../in/c.vdb"},
                                                       {"in/below/../", "c.vdb"}};
  for (const auto& [folder, name] : cases) {
    SCOPED_TRACE(folder);
    const Stack named = with_files_relative_to(stack, folder);
    EXPECT_EQ(named.layers[0].grid->file, name);
    EXPECT_TRUE(fs::weakly_canonical(fs::absolute(path_of(*named.layers[0].grid))) ==
                fs::weakly_canonical(fs::absolute("in/c.vdb")));
    // Read back from there, it is the same file.
    const Stack back = parse_stack(to_toml(named), (fs::path(folder) / "copy.toml").string(), "x");
    EXPECT_EQ(path_of(*back.layers[0].grid), path_of(*named.layers[0].grid));
  }
}

TEST(StackPaths, AnAbsoluteNameBecomesRelative) {
  const Stack stack = with_grid((fs::current_path() / "data/c.vdb").string(), "in/cloth.toml");
  EXPECT_EQ(with_files_relative_to(stack, "out").layers[0].grid->file, "../data/c.vdb");
}

TEST(StackPaths, ABuiltInGridKeepsItsNameAndIsNoFile) {
  const Stack stack = with_grid("builtin:weave", "in/cloth.toml");
  EXPECT_EQ(with_files_relative_to(stack, "out").layers[0].grid->file, "builtin:weave");
  EXPECT_TRUE(files_of(stack).empty());
}

}  // namespace
}  // namespace lamella
