/// Files appear whole or not at all, whatever fails.

#include <fcntl.h>
#include <sched.h>
#include <signal.h>
#include <sys/mount.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <filesystem>
#include <thread>

#include <gtest/gtest.h>

#include "image/files.h"
#include "image_testing.h"
#include "private_mount.h"

namespace etendue {
namespace {

using testing_image::error_of;
using testing_image::slurp;
using testing_image::spill;
using testing_image::TempFolder;

std::span<const std::byte> bytes_of(const std::string& text) {
  return std::as_bytes(std::span(text.data(), text.size()));
}

void expect_mentions(const std::string& sentence, const std::string& words) {
  EXPECT_NE(sentence.find(words), std::string::npos) << sentence << "\n  should mention: " << words;
}

constexpr int kSkip = 77;

/// Runs `body` in a child process and returns its exit code; 128 + signal when a signal ended it.
int in_child(const std::function<int()>& body) {
  const pid_t child = fork();
  if (child == 0) {
    int code = 99;
    try {
      code = body();
    } catch (...) {
    }
    _exit(code);
  }
  int status = 0;
  waitpid(child, &status, 0);
  return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
}

/// What a child reports: 0 when writing `size` bytes failed with an Error that has all `words`, left `path` as `before`
/// and no other file.
int expect_refused(const std::string& path, std::size_t size, const std::vector<std::string>& words,
                   const std::string& before) {
  const auto files = [&] {
    const std::filesystem::path folder = std::filesystem::path(path).parent_path();
    return std::distance(std::filesystem::directory_iterator(folder), {});
  };
  // The check overlooks the way through the handler below, which is the one expected.
  const auto files_before = files();  // NOLINT(clang-analyzer-deadcode.DeadStores)
  const std::string content(size, 'n');
  try {
    write_file_atomically(path, bytes_of(content));
    return 1;
  } catch (const Error& error) {
    if (error.kind() != ErrorKind::file) return 2;
    for (const std::string& word : words) {
      if (std::string(error.what()).find(word) == std::string::npos) return 3;
    }
  }
  if (slurp(path) != before) return 4;
  return files() == files_before ? 0 : 5;
}

/// In a child with its own mounts: a tmpfs over `folder`. False where that is not permitted.

TEST(AtomicFile, WritesNewFilesAndReplacesOldOnes) {
  const TempFolder folder;
  write_file_atomically(folder / "a", bytes_of("first"));
  EXPECT_EQ(slurp(folder / "a"), "first");
  write_file_atomically(folder / "a", bytes_of("second, longer"));
  EXPECT_EQ(slurp(folder / "a"), "second, longer");
  write_file_atomically(folder / "empty", {});
  EXPECT_EQ(slurp(folder / "empty"), "");
  EXPECT_EQ(folder.files(), 2u);
}

TEST(AtomicFile, WritesIntoTheCurrentFolder) {
  const TempFolder folder;
  EXPECT_EQ(in_child([&] {
              if (chdir(folder.path().c_str()) != 0) return 1;
              write_file_atomically("plain", bytes_of("x"));
              return 0;
            }),
            0);
  EXPECT_EQ(slurp(folder / "plain"), "x");
}

TEST(AtomicFile, LeavesNothingWithoutCommit) {
  const TempFolder folder;
  spill(folder / "a", "old");
  {
    AtomicFile file(folder / "a");
    file.write(bytes_of("new"));
  }
  EXPECT_EQ(slurp(folder / "a"), "old");
  EXPECT_EQ(folder.files(), 1u);
}

TEST(AtomicFile, KeepsPermissionsOfWhatItReplaces) {
  const TempFolder folder;
  spill(folder / "a", "old");
  chmod((folder / "a").c_str(), 0640);
  write_file_atomically(folder / "a", bytes_of("new"));
  struct stat status;
  ASSERT_EQ(stat((folder / "a").c_str(), &status), 0);
  EXPECT_EQ(status.st_mode & 07777, 0640u);
}

TEST(AtomicFile, FollowsSymbolicLinks) {
  const TempFolder folder;
  std::filesystem::create_directory(folder / "there");
  spill(folder / "there/real", "old");
  std::filesystem::create_symlink("there/real", folder / "link");
  write_file_atomically(folder / "link", bytes_of("new"));
  EXPECT_TRUE(std::filesystem::is_symlink(folder / "link"));
  EXPECT_EQ(slurp(folder / "there/real"), "new");
  std::filesystem::create_symlink("there/later", folder / "dangling");
  write_file_atomically(folder / "dangling", bytes_of("made"));
  EXPECT_EQ(slurp(folder / "there/later"), "made");
  std::filesystem::create_symlink("loop", folder / "loop");
  expect_mentions(error_of([&] { write_file_atomically(folder / "loop", {}); }), "symbolic link");
}

// In a sticky folder of everybody's, such as /tmp, the kernel guards links and files of others by settings of its own
// (fs.protected_symlinks, fs.protected_regular). Whatever they are, the shell is the measure.
TEST(AtomicFile, OpensWhatTheShellOpensInStickyFolders) {
  if (geteuid() != 0) GTEST_SKIP() << "only root can make links that belong to others";
  constexpr uid_t kOther = 65534;
  const TempFolder folder;
  std::filesystem::create_directory(folder / "sticky");
  chmod((folder / "sticky").c_str(), 01777);
  spill(folder / "mine", "old");
  spill(folder / "sticky/theirs", "old");
  ASSERT_EQ(chown((folder / "sticky/theirs").c_str(), kOther, kOther), 0);
  chmod((folder / "sticky/theirs").c_str(), 0666);
  const std::pair<const char*, const char*> links[] = {
      {"link", "../mine"}, {"dangling", "../later"}, {"chain", "second"}, {"second", "../mine"}};
  for (const auto& [name, target] : links) {
    std::filesystem::create_symlink(target, folder / (std::string("sticky/") + name));
    ASSERT_EQ(lchown((folder / (std::string("sticky/") + name)).c_str(), kOther, kOther), 0);
  }
  std::filesystem::create_symlink("link", folder / "sticky/own-to-theirs");
  std::filesystem::create_symlink("../mine", folder / "sticky/own");
  for (const char* name : {"link", "dangling", "chain", "own-to-theirs", "own", "theirs"}) {
    const std::string path = folder / (std::string("sticky/") + name);
    const std::string command = "sh -c ': >> " + path + "' 2> /dev/null";  // opened with O_CREAT, not emptied
    const bool shell_opens = std::system(command.c_str()) == 0;
    std::filesystem::remove(folder / "later");
    bool opens = true;
    try {
      write_file_atomically(path, bytes_of("new"));
    } catch (const Error& error) {
      opens = false;
      expect_mentions(error.what(), "Permission denied");
    }
    EXPECT_EQ(opens, shell_opens) << name;
    EXPECT_EQ(std::filesystem::exists(folder / "later"), shell_opens && name == std::string("dangling"));
    std::filesystem::remove(folder / "later");
  }
}

TEST(AtomicFile, KnowsTwoNamesOfOnePlace) {
  const TempFolder folder;
  spill(folder / "a", "");
  std::filesystem::create_hard_link(folder / "a", folder / "hard");
  std::filesystem::create_symlink("a", folder / "soft");
  std::filesystem::create_symlink("new", folder / "ahead");
  std::filesystem::create_directory_symlink(".", folder / "here");
  for (const char* name : {"a", "hard", "soft", "here/a", "here/soft"}) {
    EXPECT_TRUE(is_same_place(folder / "a", folder / name)) << name;
    EXPECT_FALSE(is_same_place(folder / "new", folder / name)) << name;
  }
  EXPECT_TRUE(is_same_place(folder / "new", folder / "ahead"));
  EXPECT_TRUE(is_same_place(folder / "new", folder / "here/new"));
  EXPECT_FALSE(is_same_place(folder / "none/a", folder / "none/a"));  // leads nowhere, which is told elsewhere
}

TEST(AtomicFile, TakesTheLongestNames) {
  const TempFolder folder;
  const std::string longest(255, 'a');
  write_file_atomically(folder / longest, bytes_of("x"));
  EXPECT_EQ(slurp(folder / longest), "x");
  expect_mentions(error_of([&] { AtomicFile(folder / (longest + "a")); }), "File name too long");
}

TEST(AtomicFile, RefusesWhatIsNoFileBeforeAnythingIsWritten) {
  const TempFolder folder;
  std::filesystem::create_directory(folder / "sub");
  ASSERT_EQ(mkfifo((folder / "pipe").c_str(), 0600), 0);
  expect_mentions(error_of([&] { AtomicFile(folder / "sub"); }), "Is a directory");
  expect_mentions(error_of([&] { AtomicFile(folder / "pipe"); }), "pipe");
  expect_mentions(error_of([&] { AtomicFile("/dev/null"); }), "device");
  expect_mentions(error_of([&] { AtomicFile(folder / "none/a"); }), "No such file or directory");
  expect_mentions(error_of([&] { AtomicFile(folder / "none/a"); }), folder / "none/a");
  expect_mentions(error_of([&] { AtomicFile(folder / "sub/"); }), "not the name of a file");
  expect_mentions(error_of([&] { AtomicFile(""); }), "not the name of a file");
  spill(folder / "a", "x");
  expect_mentions(error_of([&] { AtomicFile(folder / "a/b"); }), "Not a directory");
}

TEST(AtomicFile, ReportsAFolderThatVanished) {
  const TempFolder folder;
  std::filesystem::create_directory(folder / "sub");
  AtomicFile file(folder / "sub/a");
  file.write(bytes_of("x"));
  std::filesystem::remove_all(folder / "sub");
  expect_mentions(error_of([&] { file.commit(); }), "No such file or directory");
}

TEST(AtomicFile, ReportsAFileSizeLimitAndGoesOn) {
  const TempFolder folder;
  spill(folder / "a", "old");
  const int code = in_child([&] {
    const rlimit limit{10000, 10000};
    if (setrlimit(RLIMIT_FSIZE, &limit) != 0) return kSkip;
    // Twice: the pending signal of the first must not end the process later.
    for (int i = 0; i < 2; ++i) {
      if (const int result = expect_refused(folder / "a", 20000, {folder / "a", "File too large"}, "old"); result != 0)
        return result;
    }
    write_file_atomically(folder / "b", bytes_of("fits"));
    return 0;
  });
  if (code == kSkip) GTEST_SKIP() << "the file size limit cannot be set here";
  EXPECT_EQ(code, 0);
  EXPECT_EQ(slurp(folder / "b"), "fits");
}

TEST(AtomicFile, ReportsAFullDisk) {
  const TempFolder folder;
  const int code = in_child([&] {
    if (!mount_tmpfs(folder.path(), "size=64k")) return kSkip;
    spill(folder / "a", "old");
    if (const int result = expect_refused(folder / "a", 1 << 20, {folder / "a", "No space left on device"}, "old"))
      return result;
    write_file_atomically(folder / "a", bytes_of("small"));
    return slurp(folder / "a") == "small" ? 0 : 6;
  });
  if (code == kSkip) GTEST_SKIP() << "neither root nor user namespaces: no small file system can be mounted";
  EXPECT_EQ(code, 0);
}

TEST(AtomicFile, ReportsAReadOnlyFileSystem) {
  const TempFolder folder;
  const int code = in_child([&] {
    if (!mount_tmpfs(folder.path(), "size=64k")) return kSkip;
    spill(folder / "a", "old");
    if (mount(nullptr, folder.path().c_str(), nullptr, MS_REMOUNT | MS_RDONLY, nullptr) != 0) return kSkip;
    return expect_refused(folder / "a", 10, {folder / "a", "Read-only file system"}, "old");
  });
  if (code == kSkip) GTEST_SKIP() << "neither root nor user namespaces: no small file system can be mounted";
  EXPECT_EQ(code, 0);
}

TEST(AtomicFile, ReportsMissingPermission) {
  const TempFolder folder;
  spill(folder / "a", "old");
  chmod((folder / "a").c_str(), 0644);
  chmod(folder.path().c_str(), 0555);
  const int folder_code = in_child([&] {
    if (geteuid() == 0 && seteuid(65534) != 0) return kSkip;  // root may write anywhere
    return expect_refused(folder / "a", 10, {folder / "a", "Permission denied"}, "old");
  });
  EXPECT_TRUE(folder_code == 0 || folder_code == kSkip) << folder_code;
  // A file its owner has protected stays, though the folder would allow to replace it.
  chmod(folder.path().c_str(), 0777);
  chmod((folder / "a").c_str(), 0444);
  const int file_code = in_child([&] {
    if (geteuid() == 0 && seteuid(65534) != 0) return kSkip;
    return expect_refused(folder / "a", 10, {folder / "a", "Permission denied"}, "old");
  });
  if (folder_code == kSkip) GTEST_SKIP() << "root cannot become another user here";
  EXPECT_EQ(file_code, 0);
}

TEST(AtomicFile, WritesToAFolderItMayNotList) {
  const TempFolder folder;
  chmod(folder.path().c_str(), 0333);
  EXPECT_EQ(in_child([&] {
              if (geteuid() == 0 && seteuid(65534) != 0) return 0;
              write_file_atomically(folder / "a", bytes_of("x"));
              return 0;
            }),
            0);
}

TEST(AtomicFile, IsWholeWheneverTheProcessIsKilled) {
  const TempFolder folder;
  constexpr std::size_t kSize = 1 << 20;
  write_file_atomically(folder / "a", bytes_of(std::string(kSize, 'a')));
  const auto inode = [&] {
    struct stat status {};
    stat((folder / "a").c_str(), &status);
    return status.st_ino;
  };
  for (int round = 0; round < 12; ++round) {
    const auto before = inode();
    const pid_t child = fork();
    if (child == 0) {
      for (char letter = 'a';; letter = letter == 'z' ? 'a' : static_cast<char>(letter + 1)) {
        write_file_atomically(folder / "a", bytes_of(std::string(kSize, letter)));
      }
    }
    // On a busy machine the child may take long to begin; killed before its first file it would show nothing.
    for (int i = 0; i < 10000 && inode() == before; ++i) std::this_thread::sleep_for(std::chrono::milliseconds(1));
    EXPECT_NE(inode(), before) << "the child did not replace the file within 10 s";
    std::this_thread::sleep_for(std::chrono::microseconds(700 * round));
    kill(child, SIGKILL);
    waitpid(child, nullptr, 0);
    const std::string content = slurp(folder / "a");
    ASSERT_EQ(content.size(), kSize);
    ASSERT_EQ(content.find_first_not_of(content[0]), std::string::npos) << "a mixture of two versions";
  }
}

TEST(ReadFile, ReadsAllOrTheStart) {
  const TempFolder folder;
  spill(folder / "a", "0123456789");
  EXPECT_EQ(read_file(folder / "a").size(), 10u);
  EXPECT_EQ(read_file(folder / "a", 4).size(), 4u);
  EXPECT_EQ(read_file(folder / "a", 4)[3], std::byte{'3'});
}

TEST(ReadFile, RefusesWhatIsNoFile) {
  const TempFolder folder;
  ASSERT_EQ(mkfifo((folder / "pipe").c_str(), 0600), 0);
  expect_mentions(error_of([&] { read_file(folder / "none"); }), "No such file or directory");
  expect_mentions(error_of([&] { read_file(folder.path()); }), "Is a directory");
  expect_mentions(error_of([&] { read_file(folder / "pipe"); }), "pipe");
  expect_mentions(error_of([&] { read_file("/dev/zero"); }), "device");
}

}  // namespace
}  // namespace etendue
