/// OBJ files that hold what they should not, and files that are no files.

#include <fcntl.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>

#include <cstring>
#include <fstream>

#include <fmt/core.h>

#include "bad_inputs.h"

namespace etendue::faults {
namespace {

namespace fs = std::filesystem;

void expect_bad_mesh(const std::string& name, const std::string& obj, const std::string& words,
                     const std::string& place = R"(mesh\.obj:\d+:\d+: )") {
  expect_refused({name, {"scene.xml", scene_of_mesh(), "mesh.obj", obj}, render_scene(), 3, place, words, {}});
}

const std::vector<std::string> kNoNumbers = {"x",       "1x",
                                             "1,5",     "0x10",
                                             "nan",     "-nan",
                                             "inf",     "-Infinity",
                                             "1e999",   "1e99999999999999999999",
                                             "--1",     "+-1",
                                             "1..2",    "1e",
                                             ".",       "-",
                                             "1_0",     "1.0f",
                                             "1/2",     "\xef\xbc\x91",
                                             "\u00a01", "1;",
                                             "{1}",     "\"1\"",
                                             "1e5.0",   std::string(3000, '7') + "q"};

TEST(BadMesh, NumbersThatAreNone) {
  for (const std::string& number : kNoNumbers) {
    expect_bad_mesh("v " + number, "v 0 0 0\nv 1 0 " + number + "\nf 1 1 2\n", "", R"(mesh\.obj:2:7: )");
    expect_bad_mesh("vn " + number, "v 0 0 0\nvn 0 0 1\nvn " + number + " 0 1\nf 1//2 1 1\n", "", R"(mesh\.obj:3:4: )");
  }
}

TEST(BadMesh, Indices) {
  const std::string three = "v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvn 0 0 1\n";
  const std::vector<std::pair<std::string, std::string>> corners = {
      {"0", "index 0"},
      {"4", "index 4 of a vertex is out of range; the file has 3 so far"},
      {"-4", "index -4 of a vertex is out of range"},
      {"2147483648", "out of range"},
      {"4294967297", "out of range"},
      {"-2147483649", "out of range"},
      {"9223372036854775807", "out of range"},
      {"-9223372036854775808", "out of range"},
      {"9223372036854775808", "too large"},
      {"18446744073709551617", "too large"},
      {"1.0", "not an index"},
      {"1e0", "not an index"},
      {"0x1", "not an index"},
      {"nan", "not an index"},
      {"--1", "not an index"},
      {"/1", "no corner of a face"},
      {"//1", "no corner of a face"},
      {"1/1/1/1", "more than 3 indices"},
      {"1/1/2", "index 2 of a normal"},
      {"1//-2", "index -2 of a normal"},
      {"1//0", "index 0 of a normal"},
      {"1/x", "not an index"},
      {"1\\1", "not an index"},
      {"1,2,3", "not an index"}};
  for (const auto& [corner, words] : corners)
    expect_bad_mesh("f " + corner, fmt::format("{}f 1 2 {}\n", three, corner), words, R"(mesh\.obj:6:\d+: )");
}

TEST(BadMesh, Structure) {
  const std::vector<std::pair<std::string, std::string>> files = {
      {"v 0 0\nf 1 1 1\n", "a vertex has 2 numbers; it needs 3"},
      {"v\nf 1 1 1\n", "a vertex has 0 numbers"},
      {"v 0 0 0 1 1 1 1 1\nf 1 1 1\n", "more than 7 numbers"},
      {"v 0 0 0\nvn 0 0\nf 1//1 1 1\n", "a normal has 2 numbers"},
      {"v 0 0 0\nvn 0 0 1 0\nf 1//1 1 1\n", "more than 3 numbers"},
      {"v 0 0 0\nf 1 1\n", "a face has 2 corners; it needs 3"},
      {"v 0 0 0\nf 1\n", "a face has 1 corners"},
      {"v 0 0 0\nf\n", "a face has 0 corners"},
      {"f 1 2 3\nv 0 0 0\nv 1 0 0\nv 0 1 0\n", "the file has 0 so far"},
      {"v 1e10 0 0\nf 1 1 1\n", "coordinates up to"},
      {"v 0 -1e300 0\nf 1 1 1\n", "coordinates up to"},
      {"v 3.4028235e38 0 0\nf 1 1 1\n", "coordinates up to"},
      {std::string("v 0 0 0\0\nf 1 1 1\n", 17), "not a number"},
      {std::string("\0\0\0\0\n", 5), "binary data"},
      {"\\\n\\\n\\\nv 0 0\nf 1 1 1\n", "a vertex has 2 numbers"},
      {"v 0 \\\n0 \\\nx\nf 1 1 1\n", "\"x\" is not a number"}};
  for (const auto& [obj, words] : files) expect_bad_mesh(obj, obj, words);
}

TEST(BadMesh, FilesWithoutFaces) {
  const std::vector<std::string> files = {"",
                                          "\n\n\n",
                                          "# nothing\n",
                                          "v 0 0 0\nv 1 0 0\nv 0 1 0\n",
                                          "ply\nformat ascii 1.0\nelement vertex 3\nend_header\n",
                                          "solid cube\nfacet normal 0 0 1\nendsolid cube\n",
                                          "<html>not found</html>\n",
                                          "\377\376f\n",
                                          "p 1\nl 1 2\ncurv 0 1 2 3\n",
                                          std::string(5'000'000, '\n'),
                                          std::string(3'000'000, ' ')};
  for (const std::string& obj : files)
    expect_bad_mesh(obj.substr(0, 40), obj, "the mesh \"mesh.obj\" has no faces, nor has any other",
                    R"(scene\.xml:2:\d+: )");
}

TEST(BadMesh, LinesAndFacesWithoutEnd) {
  std::string face = "v 0 0 0\nf";
  for (int i = 0; i < 70000; ++i) face += " 1";
  expect_bad_mesh("a line of blanks", std::string(6'000'000, ' '), "this line has more than 4194304 bytes");
  expect_bad_mesh("a line of digits", "v " + std::string(6'000'000, '1'), "this line has more than 4194304 bytes");
  expect_bad_mesh(
      "joined lines",
      "v 0 0 0 " +
          [] {
            std::string lines;
            for (int i = 0; i < 1'500'000; ++i) lines += "0 \\\n";
            return lines;
          }(),
      "this line has more than 4194304 bytes");
  expect_bad_mesh("a face of 70 000 corners", face + "\n", "more than 65536 corners");
  // A comb is concave at every second corner: the dearest polygon to cut. Hundreds of them would take minutes.
  std::string combs;
  constexpr int kTeeth = 32000;
  for (int i = 0; i < kTeeth; ++i)
    combs += "v " + std::to_string(i) + " 0 0\nv " + std::to_string(i) + ".5 " + std::to_string(1 + i % 7) + " 0\n";
  for (int copy = 0; copy < 40; ++copy) {
    combs += "f";
    for (int i = 2 * kTeeth; i-- > 0;) combs.append(" ").append(std::to_string(i + 1));
    combs += "\n";
  }
  expect_bad_mesh("combs", combs, "too large to triangulate");
}

void make_socket(const fs::path& path) {
  const int descriptor = socket(AF_UNIX, SOCK_STREAM, 0);
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  std::strncpy(address.sun_path, path.c_str(), sizeof address.sun_path - 1);
  ASSERT_EQ(bind(descriptor, reinterpret_cast<const sockaddr*>(&address), sizeof address), 0) << std::strerror(errno);
  close(descriptor);
}

/// What stands where a mesh or a scene should.
struct NoFile {
  const char* name;
  const char* words;
  void (*make)(const fs::path& path);
};
const NoFile kNoFiles[] = {
    {"nothing", "cannot open the file: No such file", [](const fs::path&) {}},
    {"folder", "this is a folder", [](const fs::path& p) { fs::create_directory(p); }},
    {"fifo", "not a regular file", [](const fs::path& p) { ASSERT_EQ(mkfifo(p.c_str(), 0600), 0); }},
    {"socket", "cannot open the file", make_socket},
    {"link to nothing", "cannot open the file: No such file", [](const fs::path& p) { fs::create_symlink("gone", p); }},
    {"link into git-annex", "git-annex keeps it elsewhere; fetch it with `git annex get`",
     [](const fs::path& p) {
       fs::create_symlink("../.git/annex/objects/x1/Qz/SHA256E-s9--ab.obj/SHA256E-s9--ab.obj", p);
     }},
    {"link to itself", "Too many levels of symbolic links",
     [](const fs::path& p) { fs::create_symlink(p.filename(), p); }},
    {"link to a folder", "this is a folder", [](const fs::path& p) { fs::create_directory_symlink(".", p); }},
    {"link to /dev/zero", "not a regular file", [](const fs::path& p) { fs::create_symlink("/dev/zero", p); }},
    {"link to /dev/tty", "", [](const fs::path& p) { fs::create_symlink("/dev/tty", p); }}};

TEST(BadMesh, NoFiles) {
  for (const NoFile& file : kNoFiles) {
    expect_refused({std::string("mesh: ") + file.name,
                    {"scene.xml", scene_of_mesh()},
                    render_scene(),
                    3,
                    R"(scene\.xml:2:\d+: mesh mesh\.obj: )",
                    file.words,
                    [&](const fs::path& folder) { file.make(folder / "mesh.obj"); }});
    expect_refused({std::string("scene: ") + file.name,
                    {},
                    render_scene(),
                    3,
                    R"(scene\.xml: )",
                    file.words,
                    [&](const fs::path& folder) { file.make(folder / "scene.xml"); }});
  }
}

TEST(BadMesh, FilesNobodyMayRead) {
  expect_refused({"mesh",
                  {"scene.xml", scene_of_mesh(), "mesh.obj", "f"},
                  render_scene(),
                  3,
                  R"(scene\.xml:2:\d+: )",
                  "Permission denied",
                  [](const fs::path& folder) { fs::permissions(folder / "mesh.obj", fs::perms::none); }});
}

/// Files of gigabytes: sparse, or written once and short-lived. Only where there is room.
TEST(BadMesh, AGigabyteOfHoles) {
  const auto sparse = [](const std::string& name, off_t bytes) {
    return [=](const fs::path& folder) { ASSERT_EQ(truncate((folder / name).c_str(), bytes), 0); };
  };
  expect_refused({"zeros",
                  {"scene.xml", scene_of_mesh(), "mesh.obj", "v 0 0 0\n"},
                  render_scene(),
                  3,
                  R"(mesh\.obj:\d+:\d+: )",
                  "more than 4194304 bytes",
                  sparse("mesh.obj", off_t{1} << 31)});
  expect_refused({"scene",
                  {"scene.xml", ""},
                  render_scene(),
                  3,
                  R"(scene\.xml: )",
                  "at most 33554432",
                  sparse("scene.xml", off_t{1} << 34)});
}

}  // namespace
}  // namespace etendue::faults
