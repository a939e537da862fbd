#include "scene/obj_reader.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <string_view>
#include <unordered_map>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "scene/input_file.h"
#include "scene/line_reader.h"
#include "scene/plugins.h"
#include "scene/polygon.h"
#include "scene/text.h"

namespace etendue {
namespace {

constexpr std::uint32_t kNone = 0xffffffffu;

/// Point tests of ear clipping allowed per file: some ten seconds. A hostile file of huge comb-shaped polygons ends
/// there.
constexpr std::int64_t kMaxPolygonWork = 3'000'000'000;

struct ObjError {
  std::size_t offset;  ///< in the current line
  std::string message;
};

/// Splits a line at blanks.
class Tokens {
 public:
  explicit Tokens(std::string_view line, std::size_t at = 0) : line_(line), at_(at) {}

  /// The next token; empty at the end.
  std::string_view next() {
    while (at_ < line_.size() && is_separator(line_[at_])) ++at_;
    begin_ = at_;
    while (at_ < line_.size() && !is_separator(line_[at_])) ++at_;
    return line_.substr(begin_, at_ - begin_);
  }
  /// Where the token returned last begins.
  std::size_t offset() const { return begin_; }

 private:
  static bool is_separator(char c) { return c == ' ' || c == '\t' || c == '\v' || c == '\f'; }

  std::string_view line_;
  std::size_t at_, begin_ = 0;
};

/// What the faces refer to: as in the file, but in world space.
struct RawMesh {
  std::vector<glm::dvec3> positions;
  std::vector<glm::dvec3> normals;  ///< unit, or 0 where the file's normal has no direction
  std::vector<glm::uvec3> position_triangles;
  std::vector<glm::uvec3> normal_triangles;  ///< as long as position_triangles once a face has normals, else empty
};

class ObjParser {
 public:
  ObjParser(const ByteSource& source, const std::string& file, const glm::dmat4& world_from_object,
            Diagnostics& diagnostics)
      : lines_(source, file, ObjLimits::kMaxLine),
        file_(file),
        world_from_object_(world_from_object),
        normal_matrix_(glm::transpose(glm::inverse(glm::dmat3(world_from_object)))),
        diagnostics_(diagnostics) {}

  /// False after a reported error.
  bool parse() {
    try {
      while (lines_.next()) parse_line();
    } catch (const LineReader::TooLong& error) {
      diagnostics_.error(error.position,
                         fmt::format("this line has more than {} bytes; no face needs that", ObjLimits::kMaxLine));
      return false;
    } catch (const ObjError& error) {
      diagnostics_.error(lines_.position(error.offset), error.message);
      return false;
    }
    if (mesh_.position_triangles.empty()) {
      diagnostics_.error({file_, 0, 0}, "the mesh has no faces; export the surface as f lines");
      return false;
    }
    warn();
    return true;
  }

  RawMesh& mesh() { return mesh_; }

 private:
  struct Corner {
    std::uint32_t position = kNone;
    std::uint32_t normal = kNone;
  };

  void parse_line() {
    Tokens tokens(lines_.line());
    if (std::exchange(first_line_, false) && lines_.line().starts_with("\xef\xbb\xbf"))
      tokens = Tokens(lines_.line(), 3);
    const std::string_view keyword = tokens.next();
    if (keyword.empty() || keyword.front() == '#') return;
    if (keyword == "v") return parse_position(tokens);
    if (keyword == "f") return parse_face(tokens);
    if (keyword == "vn") return parse_normal(tokens);
    if (keyword == "vt") return parse_texture(tokens);
    static constexpr std::string_view kIgnored[] = {"g", "o", "s", "usemtl", "mtllib"};
    if (std::find(std::begin(kIgnored), std::end(kIgnored), keyword) != std::end(kIgnored)) return;
    if (keyword.find('\0') != std::string_view::npos) {
      throw ObjError{tokens.offset(), "the line holds binary data; an OBJ file is plain ASCII or UTF-8 text"};
    }
    if (std::exchange(unknown_, true)) return;
    diagnostics_.warning(
        lines_.position(tokens.offset()),
        fmt::format("lines that start with {} are not known and ignored, here and further on", text::quoted(keyword)));
  }

  static double parse_number(std::string_view token, std::size_t offset) {
    double value = 0;
    const text::NumberError error = text::parse_double(token, value);
    if (error != text::NumberError::none) throw ObjError{offset, text::describe(error, token, "a number")};
    return value;
  }

  /// Numbers up to the end of the line or a comment, `min` to `max` of them.
  std::size_t parse_numbers(Tokens& tokens, std::array<double, 8>& numbers, std::size_t min, std::size_t max,
                            const char* what) {
    std::size_t count = 0;
    for (std::string_view token = tokens.next(); !token.empty() && token.front() != '#'; token = tokens.next()) {
      if (count == max) throw ObjError{tokens.offset(), fmt::format("{} has more than {} numbers", what, max)};
      numbers[count++] = parse_number(token, tokens.offset());
    }
    if (count < min) throw ObjError{0, fmt::format("{} has {} numbers; it needs {}", what, count, min)};
    return count;
  }

  static void check_capacity(std::size_t size, std::size_t limit, const char* what) {
    if (size >= limit) throw ObjError{0, fmt::format("the file has more than {} {}; split the mesh", limit, what)};
  }

  void parse_position(Tokens& tokens) {
    check_capacity(mesh_.positions.size(), ObjLimits::kMaxVertices, "vertices");
    // Three coordinates, then perhaps a weight (for curves only) or a colour, as some exporters write.
    std::array<double, 8> n{};
    parse_numbers(tokens, n, 3, 7, "a vertex");
    const glm::dvec3 p(world_from_object_ * glm::dvec4(n[0], n[1], n[2], 1.0));
    const double largest = std::max({std::abs(p.x), std::abs(p.y), std::abs(p.z)});
    if (!(largest <= kMaxCoordinate)) {
      throw ObjError{0, fmt::format("the vertex lies at {} {} {} in world space; coordinates up to {} are supported",
                                    p.x, p.y, p.z, kMaxCoordinate)};
    }
    mesh_.positions.push_back(p);
  }

  void parse_normal(Tokens& tokens) {
    check_capacity(mesh_.normals.size(), ObjLimits::kMaxVertices, "normals");
    std::array<double, 8> n{};
    parse_numbers(tokens, n, 3, 3, "a normal");
    const double largest = std::max({std::abs(n[0]), std::abs(n[1]), std::abs(n[2])});
    glm::dvec3 normal(0.0);
    if (largest > 0.0) {
      const glm::dvec3 world = normal_matrix_ * (glm::dvec3(n[0], n[1], n[2]) / largest);
      const double size = std::max({std::abs(world.x), std::abs(world.y), std::abs(world.z)});
      if (size > 0.0 && std::isfinite(size)) normal = glm::normalize(world / size);
    }
    mesh_.normals.push_back(normal);
  }

  void parse_texture(Tokens& tokens) {
    check_capacity(textures_, ObjLimits::kMaxVertices, "texture coordinates");
    std::array<double, 8> n{};
    parse_numbers(tokens, n, 1, 3, "a texture coordinate");
    ++textures_;
  }

  /// One index of a corner, `count` elements being defined so far: 1-based, or negative from the end.
  static std::uint32_t resolve(std::string_view token, std::size_t offset, std::size_t count, const char* what) {
    std::int64_t index = 0;
    const text::NumberError error = text::parse_integer(token, index);
    if (error != text::NumberError::none) throw ObjError{offset, text::describe(error, token, "an index")};
    if (index == 0) throw ObjError{offset, fmt::format("index 0 of a {}; indices count from 1", what)};
    const auto defined = static_cast<std::int64_t>(count);
    if (index > defined || index < -defined) {
      throw ObjError{offset,
                     fmt::format("index {} of a {} is out of range; the file has {} so far", index, what, count)};
    }
    return static_cast<std::uint32_t>(index > 0 ? index - 1 : defined + index);
  }

  /// v, v/vt, v//vn or v/vt/vn.
  Corner parse_corner(std::string_view token, std::size_t offset) const {
    std::array<std::string_view, 3> parts{};
    std::array<std::size_t, 3> offsets{};
    std::size_t count = 0;
    for (std::size_t begin = 0; begin <= token.size(); ++count) {
      if (count == 3)
        throw ObjError{offset, fmt::format("{} has more than 3 indices; a corner is v, v/vt, v//vn or v/vt/vn",
                                           text::quoted(token))};
      const std::size_t slash = std::min(token.find('/', begin), token.size());
      parts[count] = token.substr(begin, slash - begin);
      offsets[count] = offset + begin;
      begin = slash + 1;
    }
    if (parts[0].empty() || (count > 1 && parts[count - 1].empty())) {
      throw ObjError{
          offset, fmt::format("{} is no corner of a face; a corner is v, v/vt, v//vn or v/vt/vn", text::quoted(token))};
    }
    Corner corner;
    corner.position = resolve(parts[0], offsets[0], mesh_.positions.size(), "vertex");
    if (!parts[1].empty()) resolve(parts[1], offsets[1], textures_, "texture coordinate");
    if (!parts[2].empty()) corner.normal = resolve(parts[2], offsets[2], mesh_.normals.size(), "normal");
    return corner;
  }

  void parse_face(Tokens& tokens) {
    corners_.clear();
    for (std::string_view token = tokens.next(); !token.empty() && token.front() != '#'; token = tokens.next()) {
      if (corners_.size() == ObjLimits::kMaxCorners) {
        throw ObjError{tokens.offset(),
                       fmt::format("the face has more than {} corners; triangulate it", ObjLimits::kMaxCorners)};
      }
      corners_.push_back(parse_corner(token, tokens.offset()));
    }
    if (corners_.size() < 3)
      throw ObjError{0, fmt::format("a face has {} corners; it needs 3 or more", corners_.size())};
    check_capacity(mesh_.position_triangles.size() + corners_.size() - 3, ObjLimits::kMaxTriangles, "triangles");
    if (corners_.size() == 3) return add_triangle({0, 1, 2});
    polygon_.clear();
    triangles_.clear();
    for (const Corner& corner : corners_) polygon_.push_back(mesh_.positions[corner.position]);
    if (!triangulate(polygon_, triangles_, polygon_work_)) {
      if (polygon_work_ <= 0)
        throw ObjError{0,
                       "the concave faces of this file are too large to triangulate here; triangulate them on export"};
      if (crossing_ == 0) first_crossing_ = lines_.position(0);
      ++crossing_;
    }
    for (const PolygonTriangle& triangle : triangles_) add_triangle(triangle);
  }

  void add_triangle(const PolygonTriangle& t) {
    const Corner &a = corners_[t.x], &b = corners_[t.y], &c = corners_[t.z];
    const bool has_normals = a.normal != kNone || b.normal != kNone || c.normal != kNone;
    if (has_normals && mesh_.normal_triangles.empty()) {
      mesh_.normal_triangles.resize(mesh_.position_triangles.size(), glm::uvec3(kNone));
    }
    mesh_.position_triangles.emplace_back(a.position, b.position, c.position);
    if (has_normals || !mesh_.normal_triangles.empty())
      mesh_.normal_triangles.emplace_back(a.normal, b.normal, c.normal);
  }

  void warn() const {
    if (crossing_ > 0) {
      diagnostics_.warning(
          first_crossing_,
          fmt::format("{} polygons of this file cross themselves, this is the first; their triangles overlap",
                      crossing_));
    }
  }

  LineReader lines_;
  const std::string& file_;
  glm::dmat4 world_from_object_;
  glm::dmat3 normal_matrix_;
  Diagnostics& diagnostics_;
  RawMesh mesh_;
  std::size_t textures_ = 0;
  bool first_line_ = true;
  bool unknown_ = false;
  std::size_t crossing_ = 0;
  SourcePosition first_crossing_;
  std::int64_t polygon_work_ = kMaxPolygonWork;
  std::vector<Corner> corners_;
  std::vector<glm::dvec3> polygon_;
  std::vector<PolygonTriangle> triangles_;
};

/// Turns the two index lists of an OBJ file into one: a vertex of the result is a pair of position and normal.
class VertexSplitter {
 public:
  explicit VertexSplitter(RawMesh& raw) : raw_(raw), first_(raw.positions.size(), Slot{}) {}

  /// Nothing if there would be more than kMaxVertices.
  std::optional<TriangleMesh> split() {
    const bool with_normals = !raw_.normal_triangles.empty();
    mesh_.positions.reserve(raw_.positions.size());
    mesh_.triangles = std::move(raw_.position_triangles);
    for (std::size_t i = 0; i < mesh_.triangles.size() && !full_; ++i) {
      glm::uvec3& triangle = mesh_.triangles[i];
      const glm::uvec3 normals = with_normals ? raw_.normal_triangles[i] : glm::uvec3(kNone);
      const glm::dvec3 ng = with_normals ? plane_normal(triangle) : glm::dvec3(0.0);
      for (int corner = 0; corner < 3; ++corner)
        triangle[corner] = vertex(triangle[corner], normals[corner], ng, with_normals);
    }
    if (full_) return std::nullopt;
    return std::move(mesh_);
  }

 private:
  struct Slot {
    std::uint32_t normal = kNone;
    std::uint32_t vertex = kNone;
  };
  /// std::hash of an integer is the integer: a file could make all of them collide.
  struct Mix {
    std::size_t operator()(std::uint64_t x) const {
      x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9u;
      x = (x ^ (x >> 27)) * 0x94d049bb133111ebu;
      return x ^ (x >> 31);
    }
  };

  glm::dvec3 plane_normal(const glm::uvec3& t) const {
    const glm::dvec3 n =
        glm::cross(raw_.positions[t.y] - raw_.positions[t.x], raw_.positions[t.z] - raw_.positions[t.x]);
    const double length = glm::length(n);
    return length > 0.0 ? n / length
                        : glm::dvec3(0.0, 0.0, 1.0);  // no ray hits a triangle without area: any unit vector will do
  }

  std::uint32_t add(std::uint32_t position) {
    full_ = full_ || mesh_.positions.size() == ObjLimits::kMaxVertices;
    if (full_) return 0;
    mesh_.positions.push_back(raw_.positions[position]);
    return static_cast<std::uint32_t>(mesh_.positions.size() - 1);
  }

  std::uint32_t vertex(std::uint32_t position, std::uint32_t normal, const glm::dvec3& ng, bool with_normals) {
    const bool flat = with_normals && (normal == kNone || raw_.normals[normal] == glm::dvec3(0.0));
    if (flat) {
      const std::uint32_t added = add(position);
      if (!full_) mesh_.normals.push_back(ng);
      return added;
    }
    // Nearly every vertex has one normal: the first one is kept in a flat array, only further ones in the hash table.
    Slot& slot = first_[position];
    if (slot.vertex != kNone && slot.normal == normal) return slot.vertex;
    std::uint32_t* target = &slot.vertex;
    if (slot.vertex != kNone) {
      target = &further_.try_emplace(std::uint64_t{position} << 32 | normal, kNone).first->second;
      if (*target != kNone) return *target;
    } else {
      slot.normal = normal;
    }
    *target = add(position);
    if (with_normals && !full_) mesh_.normals.push_back(raw_.normals[normal]);
    return *target;
  }

  RawMesh& raw_;
  TriangleMesh mesh_;
  std::vector<Slot> first_;
  bool full_ = false;
  std::unordered_map<std::uint64_t, std::uint32_t, Mix> further_;
};

void warn_degenerate(const TriangleMesh& mesh, const std::string& file, Diagnostics& diagnostics) {
  const auto degenerate = std::count_if(mesh.triangles.begin(), mesh.triangles.end(),
                                        [&](const glm::uvec3& t) { return !(triangle_area(mesh, t) > 0.0); });
  if (degenerate == 0) return;
  diagnostics.warning({file, 0, 0}, fmt::format("{} of {} triangles have no area; no ray hits them", degenerate,
                                                mesh.triangles.size()));
}

}  // namespace

double triangle_area(const TriangleMesh& mesh, const glm::uvec3& t) {
  const glm::dvec3 &p0 = mesh.positions[t.x], &p1 = mesh.positions[t.y], &p2 = mesh.positions[t.z];
  return 0.5 * glm::length(glm::cross(p1 - p0, p2 - p0));
}

std::optional<TriangleMesh> read_obj(const ByteSource& source, const std::string& file,
                                     const glm::dmat4& world_from_object, Diagnostics& diagnostics) {
  ObjParser parser(source, file, world_from_object, diagnostics);
  if (!parser.parse()) return std::nullopt;
  std::optional<TriangleMesh> mesh = VertexSplitter(parser.mesh()).split();
  if (mesh) {
    warn_degenerate(*mesh, file, diagnostics);
  } else {
    diagnostics.error({file, 0, 0},
                      fmt::format("the mesh has more than {} vertices with different normals; split the mesh",
                                  ObjLimits::kMaxVertices));
  }
  return mesh;
}

std::optional<TriangleMesh> read_obj(const std::string& path, const glm::dmat4& world_from_object,
                                     Diagnostics& diagnostics) {
  InputFile file(path);
  return read_obj([&](char* buffer, std::size_t capacity) { return file.read(buffer, capacity); }, path,
                  world_from_object, diagnostics);
}

}  // namespace etendue
