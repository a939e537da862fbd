#include "sculpt/mesh.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <span>
#include <utility>

#include "core/errors.h"
#include "image/files.h"
#include "sculpt/field.h"

namespace etendue::sculpt {
namespace {

constexpr double kFileUnit = 1e-6;  // six decimals

Vec3 rounded(Vec3 p) {
  const auto round = [](double x) { return std::floor(x / kFileUnit + 0.5) * kFileUnit; };
  return {round(p.x), round(p.y), round(p.z)};
}

[[noreturn]] void fail(const std::string& sentence) {
  throw Error(ErrorKind::comparison, sentence);
}

void check_edges(const Mesh& mesh) {
  std::vector<std::uint64_t> forward, backward;
  for (const auto& t : mesh.triangles)
    for (int i = 0; i < 3; ++i) {
      const std::uint64_t a = t[i], b = t[(i + 1) % 3];
      forward.push_back(a << 32 | b);
      backward.push_back(b << 32 | a);
    }
  std::sort(forward.begin(), forward.end());
  std::sort(backward.begin(), backward.end());
  if (std::adjacent_find(forward.begin(), forward.end()) != forward.end() || forward != backward)
    fail(
        "the sculpted mesh is not closed: an edge lacks its partner; its solid touches its box or is steeper than it "
        "says");
}

}  // namespace

bool faces_away(const Mesh& mesh, const std::array<std::uint32_t, 3>& t) {
  const Vec3 n = cross(mesh.positions[t[1]] - mesh.positions[t[0]], mesh.positions[t[2]] - mesh.positions[t[0]]);
  return std::any_of(t.begin(), t.end(), [&](std::uint32_t i) { return !(dot(n, mesh.normals[i]) > 0.0); });
}

void check_closed(const Mesh& mesh) {
  check_edges(mesh);
  std::uint64_t folded = 0;
  for (const auto& t : mesh.triangles) {
    const Vec3 p0 = rounded(mesh.positions[t[0]]), p1 = rounded(mesh.positions[t[1]]),
               p2 = rounded(mesh.positions[t[2]]);
    if (!(length(cross(p1 - p0, p2 - p0)) > 0.1 * kFileUnit * kFileUnit))
      fail("the sculpted mesh has a triangle without area; ask for fewer triangles");
    if (faces_away(mesh, t)) ++folded;
  }
  if (folded * 1000 > mesh.triangles.size())
    fail(fmt::format("{} of {} sculpted triangles are folded; ask for more triangles", folded, mesh.triangles.size()));
}

Mesh grid(std::uint64_t triangles) {
  std::uint64_t n = 1;
  while (2 * n * n < triangles) ++n;
  Mesh mesh;
  for (std::uint64_t i = 0; i <= n; ++i)
    for (std::uint64_t j = 0; j <= n; ++j) {
      const double x = static_cast<double>(i) / static_cast<double>(n),
                   z = static_cast<double>(j) / static_cast<double>(n);
      mesh.positions.push_back({x - 0.5, 0.03 * noise({7.0 * x, 0.5, 7.0 * z}), z - 0.5});
    }
  const auto at = [n](std::uint64_t i, std::uint64_t j) { return static_cast<std::uint32_t>(i * (n + 1) + j); };
  for (std::uint64_t i = 0; i < n; ++i)
    for (std::uint64_t j = 0; j < n; ++j) {
      mesh.triangles.push_back({at(i, j), at(i, j + 1), at(i + 1, j + 1)});
      mesh.triangles.push_back({at(i, j), at(i + 1, j + 1), at(i + 1, j)});
    }
  return mesh;
}

Mesh soup(std::uint64_t triangles) {
  Mesh mesh;
  const auto random = [](std::uint64_t i, std::uint32_t k) {
    return signed_unit(hash(static_cast<std::uint32_t>(i), k, 1u));
  };
  for (std::uint64_t i = 0; i < triangles; ++i) {
    const auto first = static_cast<std::uint32_t>(mesh.positions.size());
    const Vec3 center{0.48 * random(i, 0), 0.48 * random(i, 1), 0.48 * random(i, 2)};
    for (std::uint32_t k = 3; k < 12; k += 3)
      mesh.positions.push_back(center + 0.02 * Vec3{random(i, k), random(i, k + 1), random(i, k + 2)});
    mesh.triangles.push_back({first, first + 1, first + 2});
  }
  return mesh;
}

Mesh lamps(std::uint64_t triangles) {
  Mesh mesh;
  // Multiples of these numbers, modulo 1, are spread evenly over a square, whatever their number.
  constexpr double kStepX = 0.7548776662466927, kStepZ = 0.5698402909980532;
  const double side = 0.2 / std::sqrt(static_cast<double>(triangles));
  for (std::uint64_t i = 0; i < triangles; ++i) {
    const auto random = [&](std::uint32_t k) { return signed_unit(hash(static_cast<std::uint32_t>(i), k, 2u)); };
    const double n = static_cast<double>(i) + 0.5;
    const Vec3 center{2.0 * (n * kStepX - std::floor(n * kStepX)) - 1.0, 0.2 + 0.14 * random(0),
                      2.0 * (n * kStepZ - std::floor(n * kStepZ)) - 1.0};
    const double size = side * (1.0 + 0.5 * random(1)), tilt_x = 0.6 * random(2), tilt_z = 0.6 * random(3);
    const auto first = static_cast<std::uint32_t>(mesh.positions.size());
    // Clockwise as seen from above, so that the normal points down, slightly tilted.
    for (const auto& [x, z] : {std::pair{-0.577, -1.0}, {1.155, 0.0}, {-0.577, 1.0}})
      mesh.positions.push_back(center + size * Vec3{x, tilt_x * x + tilt_z * z, z});
    mesh.triangles.push_back({first, first + 1, first + 2});
  }
  return mesh;
}

void write_obj(const Mesh& mesh, const std::string& title, const std::string& path) {
  fmt::memory_buffer text;
  const auto out = std::back_inserter(text);
  fmt::format_to(out, "# {}\n# {} vertices, {} triangles\n", title, mesh.positions.size(), mesh.triangles.size());
  const auto line = [&](const char* word, Vec3 p) {
    const Vec3 q = rounded(p) + Vec3{0.0, 0.0, 0.0};  // adding zero turns -0 into 0
    fmt::format_to(out, "{} {:.6f} {:.6f} {:.6f}\n", word, q.x, q.y, q.z);
  };
  for (const Vec3& p : mesh.positions) line("v", p);
  for (const auto& uv : mesh.uvs) fmt::format_to(out, "vt {:.6f} {:.6f}\n", uv[0], uv[1]);
  for (const Vec3& n : mesh.normals) line("vn", n);
  const auto corner = [&](std::uint32_t vertex) {
    const auto i = vertex + 1;
    if (!mesh.uvs.empty() && !mesh.normals.empty()) return fmt::format("{}/{}/{}", i, i, i);
    if (!mesh.uvs.empty()) return fmt::format("{}/{}", i, i);
    return mesh.normals.empty() ? fmt::format("{}", i) : fmt::format("{}//{}", i, i);
  };
  for (const auto& t : mesh.triangles) fmt::format_to(out, "f {} {} {}\n", corner(t[0]), corner(t[1]), corner(t[2]));
  write_file_atomically(path, std::as_bytes(std::span(text.data(), text.size())));
}

}  // namespace etendue::sculpt
