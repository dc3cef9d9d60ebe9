#include "compare/files/content_hash.h"

#include <gmock/gmock.h>

#include "compare/files/output_folder.h"
#include "tests/compare/files/temporary_folder.h"

namespace lamella {
namespace {

// The examples of FIPS 180-4's companion, "Secure Hash Standard Validation System" and NIST's
// example values: "abc", and a million times "a".
constexpr const char* kAbc = "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad";
constexpr const char* kMillion = "cdc76e5c9914fb9281a1c7e284d73e67f1809a48a497200e046d39ccc7112cd0";

TEST(ContentHash, IsSha256) {
  EXPECT_EQ(content_hash("abc"), kAbc);
  EXPECT_EQ(content_hash(""), "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855");
}

TEST(ContentHash, OfAFileLongerThanAPieceIsThatOfItsBytes) {
  const TemporaryFolder folder;
  write_file(folder / "a", std::string(1000000, 'a'));
  EXPECT_EQ(content_hash_of_file(folder / "a"), kMillion);
}

TEST(ContentHash, OfWhatCannotBeReadIsRefusedByName) {
  const TemporaryFolder folder;
  for (const auto& path : {folder / "absent", folder.path()})
    EXPECT_THAT(message_of<OutputError>([&] { (void)content_hash_of_file(path); }),
                testing::HasSubstr("cannot read " + path.string()));
}

}  // namespace
}  // namespace lamella
