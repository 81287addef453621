// db/files/safe_file.h: the whole file or what was there before; published hashes.
#include "db/files/safe_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/stat.h>

#include <csignal>

#include "tests/support/program.h"

namespace tendril {
namespace {

using testing::HasSubstr;
using testing_support::TemporaryFolder;

// Files may not grow past `bytes` while this lives: a disk that is full, without needing one.
class SmallDisk {
 public:
  explicit SmallDisk(rlim_t bytes) {
    signal_ = std::signal(SIGXFSZ, SIG_IGN);
    getrlimit(RLIMIT_FSIZE, &before_);
    const rlimit now{bytes, before_.rlim_max};
    setrlimit(RLIMIT_FSIZE, &now);
  }
  SmallDisk(const SmallDisk&) = delete;
  SmallDisk& operator=(const SmallDisk&) = delete;
  ~SmallDisk() {
    setrlimit(RLIMIT_FSIZE, &before_);
    std::signal(SIGXFSZ, signal_);
  }

 private:
  rlimit before_{};
  void (*signal_)(int) = nullptr;
};

size_t FilesIn(const std::filesystem::path& folder) {
  return static_cast<size_t>(std::distance(std::filesystem::directory_iterator(folder), {}));
}

TEST(SafeFile, HashesAreThoseOfTheStandard) {  // FIPS 180-2, appendix B
  EXPECT_EQ(Sha256(""), "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855");
  EXPECT_EQ(Sha256("abc"), "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
  const TemporaryFolder folder;
  ASSERT_TRUE(WriteText(folder / "million", std::string(1'000'000, 'a')).ok());
  EXPECT_EQ(Sha256OfFile(folder / "million").value(),
            "cdc76e5c9914fb9281a1c7e284d73e67f1809a48a497200e046d39ccc7112cd0");
}

TEST(SafeFile, WritesAndReplacesWholeFilesAndLeavesNothingElse) {
  const TemporaryFolder folder;
  for (const std::string& text : {std::string("first"), std::string(), std::string("nul\0inside", 10)}) {
    ASSERT_TRUE(WriteText(folder / "a.txt", text).ok());
    EXPECT_EQ(ReadText(folder / "a.txt").value(), text);
    EXPECT_EQ(FilesIn(folder.path()), 1U);
  }
}

TEST(SafeFile, AFullDiskLeavesTheFileAsItWas) {
  const TemporaryFolder folder;
  ASSERT_TRUE(WriteText(folder / "a.txt", "before").ok());
  {
    const SmallDisk disk(1000);
    const Status full = WriteText(folder / "a.txt", std::string(5000, 'x'));
    ASSERT_FALSE(full.ok());
    EXPECT_EQ(full.error().kind, ErrorKind::kIo);
    EXPECT_THAT(full.error().message, HasSubstr("a.txt"));
  }
  EXPECT_EQ(ReadText(folder / "a.txt").value(), "before");
  EXPECT_EQ(FilesIn(folder.path()), 1U);
}

TEST(SafeFile, DevicesAreWrittenStraightAndNeverReplaced) {
  const Status full = WriteText("/dev/full", "text");
  ASSERT_FALSE(full.ok());
  EXPECT_EQ(full.error().kind, ErrorKind::kIo);
  EXPECT_TRUE(WriteText("/dev/null", "text").ok());
  EXPECT_TRUE(std::filesystem::is_character_file("/dev/null"));
}

TEST(SafeFile, KeepsLinksAndPermissions) {
  const TemporaryFolder folder;
  ASSERT_TRUE(WriteText(folder / "real.txt", "before").ok());
  ASSERT_EQ(::chmod((folder / "real.txt").c_str(), 0640), 0);
  std::filesystem::create_symlink("real.txt", folder / "link.txt");
  ASSERT_TRUE(WriteText(folder / "link.txt", "after").ok());
  EXPECT_TRUE(std::filesystem::is_symlink(folder / "link.txt"));
  EXPECT_EQ(ReadText(folder / "real.txt").value(), "after");
  EXPECT_EQ(static_cast<int>(std::filesystem::status(folder / "real.txt").permissions()), 0640);
}

TEST(SafeFile, AWriterThatFailsLeavesNothing) {
  const TemporaryFolder folder;
  const Status s = WriteBeside(folder / "a.h5", [](const std::filesystem::path& beside) -> Status {
    EXPECT_EQ(beside.extension(), ".h5");
    EXPECT_TRUE(WriteText(beside, "half").ok());
    return Error{ErrorKind::kIo, "no more"};
  });
  EXPECT_EQ(s.error().message, "no more");
  EXPECT_EQ(FilesIn(folder.path()), 0U);
}

TEST(SafeFile, MissingFilesAndFoldersAreNotFound) {
  const TemporaryFolder folder;
  EXPECT_EQ(ReadText(folder / "none").error().kind, ErrorKind::kNotFound);
  EXPECT_EQ(Sha256OfFile(folder / "none").error().kind, ErrorKind::kNotFound);
  EXPECT_EQ(WriteText(folder / "none/a.txt", "x").error().kind, ErrorKind::kNotFound);
  EXPECT_FALSE(ReadText(folder.path()).ok()) << "a folder is no text";
}

}  // namespace
}  // namespace tendril
