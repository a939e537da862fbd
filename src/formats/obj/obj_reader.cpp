#include "formats/obj/obj_reader.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <limits>
#include <map>
#include <string_view>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "core/memory.h"
#include "core/text.h"
#include "formats/input_file.h"
#include "formats/line_reader.h"
#include "formats/mesh/polygon.h"

namespace etendue {
namespace {

constexpr std::uint32_t kNone = 0xffffffffu;

/// Number of errors listed for one file; nobody reads more.
constexpr std::size_t kMaxErrors = 20;

struct ObjError {
  std::size_t offset;  ///< in the current line
  std::string message;
  bool last = false;  ///< reading on makes no sense
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
  /// The offset of the last token.
  std::size_t offset() const { return begin_; }
  /// The offset of the text after it.
  std::size_t end() const { return at_; }

 private:
  static bool is_separator(char c) { return c == ' ' || c == '\t' || c == '\v' || c == '\f'; }

  std::string_view line_;
  std::size_t at_, begin_ = 0;
};

/// What the faces refer to, as in the file.
struct RawMesh {
  std::vector<glm::dvec3> positions;
  std::vector<glm::dvec3> normals;  ///< unit, or 0 where the file's normal has no direction
  std::vector<glm::uvec3> position_triangles;
  std::vector<glm::uvec3> normal_triangles;  ///< as long as position_triangles once a face has normals, else empty
  std::vector<glm::vec2> uvs;
  std::vector<glm::uvec3> uv_triangles;  ///< the same for texture coordinates
  std::vector<glm::vec3> colors;         ///< of positions, linear; empty unless one of them has a colour
};

/// Positions or normals whose lines are wrong: an error where a face uses the element, else a warning. Exporters write
/// `vn nan nan nan` for corners that no face has.
class BadElements {
 public:
  BadElements(const char* what, Diagnostics& diagnostics) : what_(what), diagnostics_(diagnostics) {}

  static constexpr double kMark = std::numeric_limits<double>::quiet_NaN();  ///< x of a bad element

  void add(std::size_t index, const SourcePosition& position, std::string message) {
    if (kept_.size() < kMaxErrors) kept_.emplace(index, Bad{position, std::move(message)});
    ++count_;
  }
  bool contains(const glm::dvec3& element) const { return count_ > 0 && std::isnan(element.x); }

  /// A face has the element: reports its line. False if that was done before.
  bool report_used(std::size_t index, const SourcePosition& face) {
    const auto found = kept_.find(index);
    if (found == kept_.end()) {
      // Reports it once if its line is no longer known, because every further face would give the same message.
      if (std::exchange(reported_unkept_, true) || count_ <= kMaxErrors) return false;
      diagnostics_.error(face, fmt::format("{} {} of this face could not be read", what_, index + 1));
      return true;
    }
    if (std::exchange(found->second.used, true)) return false;
    diagnostics_.error(found->second.position, found->second.message);
    return true;
  }

  void warn_unused() const {
    if (count_ == 0) return;
    const Bad& first = kept_.begin()->second;
    const std::string others = count_ > 1 ? fmt::format(", nor {} more like it", count_ - 1) : std::string();
    diagnostics_.warning(first.position,
                         fmt::format("{}; no face uses this {}{}: left out", first.message, what_, others));
  }

 private:
  struct Bad {
    SourcePosition position;
    std::string message;
    bool used = false;
  };
  const char* what_;
  Diagnostics& diagnostics_;
  std::map<std::size_t, Bad> kept_;  ///< the first few
  std::size_t count_ = 0;
  bool reported_unkept_ = false;
};

class ObjParser {
 public:
  ObjParser(const ByteSource& source, const std::string& file, const MeshContent& content, ObjMaterials* materials,
            Diagnostics& diagnostics)
      : lines_(source, file, ObjLimits::kMaxLine),
        content_(content),
        materials_(materials),
        diagnostics_(diagnostics),
        bad_positions_("vertex", diagnostics),
        bad_normals_("normal", diagnostics) {}

  /// False after a reported error.
  bool parse() {
    try {
      while (lines_.next()) parse_line_or_report();
    } catch (const LineReader::TooLong& error) {
      diagnostics_.error(error.position,
                         fmt::format("this line has more than {} bytes; no face needs that", ObjLimits::kMaxLine));
      return false;
    } catch (const EndOfReading&) {
      return false;
    }
    if (errors_ > 0) return false;
    drop_unusable();
    warn();
    return true;
  }

  RawMesh& mesh() { return mesh_; }

 private:
  struct Corner {
    std::uint32_t position = kNone;
    std::uint32_t normal = kNone;
    std::uint32_t uv = kNone;
  };

  struct EndOfReading {};

  /// A line with an error is skipped, so that one pass lists them all.
  void parse_line_or_report() {
    try {
      parse_line();
    } catch (const ObjError& error) {
      diagnostics_.error(lines_.position(error.offset), error.message);
      if (error.last) throw EndOfReading{};
      count_error();
    }
  }

  void count_error() {
    if (++errors_ == kMaxErrors) throw EndOfReading{};
  }

  /// Reads the element that was put at the end of `elements`; if that fails, its place is marked and its line kept.
  template <typename Read>
  void read_element(std::vector<glm::dvec3>& elements, BadElements& bad, const Read& read) {
    try {
      elements.back() = read();
    } catch (const ObjError& error) {
      elements.back() = glm::dvec3(BadElements::kMark);
      bad.add(elements.size() - 1, lines_.position(error.offset), error.message);
    }
  }

  void parse_line() {
    Tokens tokens(lines_.line());
    if (std::exchange(first_line_, false)) {
      if (lines_.line().starts_with("\xef\xbb\xbf")) tokens = Tokens(lines_.line(), 3);
      if (const char* pointer = text::pointer_sentence(lines_.line())) throw ObjError{0, pointer, true};
    }
    const std::string_view keyword = tokens.next();
    if (keyword.empty() || keyword.front() == '#') return;
    if (keyword == "v") return parse_position(tokens);
    if (keyword == "f") return parse_face(tokens);
    if (keyword == "vn") return parse_normal(tokens);
    if (keyword == "vt") return parse_texture(tokens);
    if (materials_ != nullptr && keyword == "usemtl") return use_material(rest_of(tokens));
    if (materials_ != nullptr && keyword == "mtllib") return add_library(rest_of(tokens));
    static constexpr std::string_view kIgnored[] = {"g", "o", "s", "usemtl", "mtllib"};
    if (std::find(std::begin(kIgnored), std::end(kIgnored), keyword) != std::end(kIgnored)) return;
    if (keyword.find('\0') != std::string_view::npos) {
      throw ObjError{tokens.offset(), "the line holds binary data; an OBJ file is plain ASCII or UTF-8 text", true};
    }
    if (std::exchange(unknown_, true)) return;
    diagnostics_.warning(
        lines_.position(tokens.offset()),
        fmt::format("lines that start with {} are unknown and ignored, here and below", text::quoted(keyword)));
  }

  /// Names may hold blanks.
  std::string_view rest_of(const Tokens& tokens) {
    return text::trim(lines_.line().substr(std::min(tokens.end(), lines_.line().size())));
  }

  void use_material(std::string_view name) {
    const auto [known, is_new] = material_rows_.try_emplace(std::string(name), materials_->names.size());
    if (is_new) {
      if (materials_->names.size() >= ObjMaterials::kMost)
        throw ObjError{0, fmt::format("the file has more than {} materials; split it", ObjMaterials::kMost), true};
      materials_->names.emplace_back(name);
    }
    material_ = static_cast<std::uint32_t>(known->second);
  }

  void add_library(std::string_view name) {
    if (materials_->libraries.size() >= ObjMaterials::kMost)
      throw ObjError{0, fmt::format("the file names more than {} libraries", ObjMaterials::kMost), true};
    materials_->libraries.emplace_back(name);
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
    if (size >= limit)
      throw ObjError{0, fmt::format("the file has more than {} {}; split the mesh", limit, what), true};
  }

  void parse_position(Tokens& tokens) {
    check_capacity(mesh_.positions.size(), kMaxVertices, "vertices");
    mesh_.positions.emplace_back(0.0);  // counts even if the line is wrong, or all later faces would be wrong, too
    read_element(mesh_.positions, bad_positions_, [&] {
      // Three coordinates, then perhaps a weight (for curves only) or a colour, as some exporters write, with alpha.
      std::array<double, 8> n{};
      if (parse_numbers(tokens, n, 3, 7, "a vertex") >= 6) add_color(glm::dvec3(n[3], n[4], n[5]));
      const glm::dvec3 p(n[0], n[1], n[2]);
      const double largest = std::max({std::abs(p.x), std::abs(p.y), std::abs(p.z)});
      if (!(largest <= kMaxCoordinate)) {
        throw ObjError{0, fmt::format("the vertex is at {} {} {}; coordinates up to {} are supported", p.x, p.y, p.z,
                                      kMaxCoordinate)};
      }
      return p;
    });
  }

  /// Sets the colour of the last vertex.
  void add_color(const glm::dvec3& color) {
    if (!content_.colors || bad_color_) return;
    if (!(std::min({color.x, color.y, color.z}) >= 0.0 && std::max({color.x, color.y, color.z}) <= 1.0)) {
      bad_color_ = true;
      diagnostics_.warning(
          lines_.position(0),
          fmt::format("the colour {} {} {} of this vertex is not between 0 and 1; colours are ignored, here and below",
                      color.x, color.y, color.z));
      return;
    }
    mesh_.colors.resize(mesh_.positions.size(), glm::vec3(1.0f));
    mesh_.colors.back() = linear_from_srgb(glm::vec3(color));
    ++colored_;
  }

  void parse_normal(Tokens& tokens) {
    check_capacity(mesh_.normals.size(), kMaxVertices, "normals");
    mesh_.normals.emplace_back(0.0);
    read_element(mesh_.normals, bad_normals_, [&] {
      std::array<double, 8> n{};
      parse_numbers(tokens, n, 3, 3, "a normal");
      const double largest = std::max({std::abs(n[0]), std::abs(n[1]), std::abs(n[2])});
      return largest > 0.0 ? glm::normalize(glm::dvec3(n[0], n[1], n[2]) / largest) : glm::dvec3(0.0);
    });
  }

  void parse_texture(Tokens& tokens) {
    check_capacity(textures_, kMaxVertices, "texture coordinates");
    ++textures_;
    std::array<double, 8> n{};
    try {
      parse_numbers(tokens, n, 1, 3, "a texture coordinate");
      constexpr double kLargest = std::numeric_limits<float>::max();
      if (std::max(std::abs(n[0]), std::abs(n[1])) > kLargest)
        throw ObjError{0, fmt::format("a texture coordinate is larger than {}", kLargest)};
      if (content_.uv && !bad_texture_) mesh_.uvs.emplace_back(n[0], n[1]);
    } catch (const ObjError& error) {
      warn_texture(error);
    }
  }

  /// Reported once per file, because nothing is lost.
  void warn_texture(const ObjError& error) {
    if (std::exchange(bad_texture_, true)) return;
    diagnostics_.warning(lines_.position(error.offset),
                         error.message + "; texture coordinates are ignored, here and below");
  }

  static std::int64_t parse_index(std::string_view token, std::size_t offset) {
    std::int64_t index = 0;
    const text::NumberError error = text::parse_integer(token, index);
    if (error != text::NumberError::none) throw ObjError{offset, text::describe(error, token, "an index")};
    return index;
  }

  /// One index of a corner, `count` elements being defined so far: 1-based, or negative from the end.
  static std::uint32_t resolve(std::string_view token, std::size_t offset, std::size_t count, const char* what) {
    const std::int64_t index = parse_index(token, offset);
    if (index == 0) throw ObjError{offset, fmt::format("index 0 of a {}; indices count from 1", what)};
    const auto defined = static_cast<std::int64_t>(count);
    if (index > defined || index < -defined) {
      throw ObjError{offset,
                     fmt::format("index {} of a {} is out of range; the file has {} so far", index, what, count)};
    }
    return static_cast<std::uint32_t>(index > 0 ? index - 1 : defined + index);
  }

  /// v, v/vt, v//vn or v/vt/vn; what follows v may be empty, as some exporters write: v/, v//, v/vt/.
  Corner parse_corner(std::string_view token, std::size_t offset) {
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
    if (parts[0].empty()) {
      throw ObjError{
          offset, fmt::format("{} is no corner of a face; a corner is v, v/vt, v//vn or v/vt/vn", text::quoted(token))};
    }
    Corner corner;
    corner.position = resolve(parts[0], offsets[0], mesh_.positions.size(), "vertex");
    if (!parts[1].empty()) corner.uv = texture_index(parts[1], offsets[1]);
    if (!parts[2].empty()) corner.normal = resolve(parts[2], offsets[2], mesh_.normals.size(), "normal");
    return corner;
  }

  /// kNone if it cannot be used.
  std::uint32_t texture_index(std::string_view token, std::size_t offset) {
    if (bad_texture_) {
      parse_index(token, offset);  // already reported
      return kNone;
    }
    try {
      const std::uint32_t index = resolve(token, offset, textures_, "texture coordinate");
      return content_.uv ? index : kNone;
    } catch (const ObjError& error) {
      parse_index(token, offset);  // anything that is not an index remains an error
      warn_texture(error);
      return kNone;
    }
  }

  /// False if the face has a vertex or normal that could not be read, which has then been reported.
  bool has_good_elements() {
    bool good = true;
    const auto check = [&](BadElements& bad, const std::vector<glm::dvec3>& elements, std::uint32_t index) {
      if (index == kNone || !bad.contains(elements[index])) return;
      good = false;
      if (bad.report_used(index, lines_.position(0))) count_error();
    };
    for (const Corner& corner : corners_) {
      check(bad_positions_, mesh_.positions, corner.position);
      check(bad_normals_, mesh_.normals, corner.normal);
    }
    return good;
  }

  void parse_face(Tokens& tokens) {
    corners_.clear();
    for (std::string_view token = tokens.next(); !token.empty() && token.front() != '#'; token = tokens.next()) {
      if (corners_.size() == kMaxCorners) {
        throw ObjError{tokens.offset(), fmt::format("the face has more than {} corners; triangulate it", kMaxCorners)};
      }
      corners_.push_back(parse_corner(token, tokens.offset()));
    }
    if (corners_.size() < 3)
      throw ObjError{0, fmt::format("a face has {} corners; it needs 3 or more", corners_.size())};
    if (!has_good_elements()) return;
    check_capacity(mesh_.position_triangles.size() + corners_.size() - 3, kMaxTriangles, "triangles");
    if (corners_.size() == 3) return add_triangle({0, 1, 2});
    polygon_.clear();
    triangles_.clear();
    for (const Corner& corner : corners_) polygon_.push_back(mesh_.positions[corner.position]);
    if (!triangulate(polygon_, triangles_, polygon_work_)) {
      if (polygon_work_ <= 0)
        throw ObjError{
            0, "the concave faces of this file are too large to triangulate here; triangulate them on export", true};
      if (crossing_ == 0) first_crossing_ = lines_.position(0);
      ++crossing_;
    }
    for (const PolygonTriangle& triangle : triangles_) add_triangle(triangle);
  }

  void add_triangle(const PolygonTriangle& t) {
    const Corner &a = corners_[t.x], &b = corners_[t.y], &c = corners_[t.z];
    add_further(mesh_.normal_triangles, {a.normal, b.normal, c.normal});
    add_further(mesh_.uv_triangles, {a.uv, b.uv, c.uv});
    mesh_.position_triangles.emplace_back(a.position, b.position, c.position);
    if (materials_ != nullptr) materials_->of_triangle.push_back(material_);
  }

  /// Indices that need not be there: the list begins with the first triangle that has one, the others before it.
  void add_further(std::vector<glm::uvec3>& triangles, const glm::uvec3& triangle) const {
    const bool has_any = triangle != glm::uvec3(kNone);
    if (has_any && triangles.empty()) triangles.resize(mesh_.position_triangles.size(), glm::uvec3(kNone));
    if (has_any || !triangles.empty()) triangles.push_back(triangle);
  }

  /// Texture coordinates and colours of which some could not be read.
  void drop_unusable() {
    if (bad_texture_) {
      release(mesh_.uvs);
      release(mesh_.uv_triangles);
    }
    if (bad_color_) release(mesh_.colors);
    if (!mesh_.colors.empty()) mesh_.colors.resize(mesh_.positions.size(), glm::vec3(1.0f));
  }

  void warn() const {
    bad_positions_.warn_unused();
    bad_normals_.warn_unused();
    if (!mesh_.colors.empty() && colored_ < mesh_.positions.size()) {
      diagnostics_.warning({lines_.position(0).file, 0, 0},
                           fmt::format("{} of {} vertices have no colour; they are white",
                                       mesh_.positions.size() - colored_, mesh_.positions.size()));
    }
    if (crossing_ > 0) {
      diagnostics_.warning(
          first_crossing_,
          fmt::format("{} polygons of this file cross themselves, of which this is the first; their triangles overlap",
                      crossing_));
    }
  }

  LineReader lines_;
  MeshContent content_;
  ObjMaterials* materials_;
  std::map<std::string, std::size_t, std::less<>> material_rows_ = {{"", 0}};
  std::uint32_t material_ = 0;
  Diagnostics& diagnostics_;
  BadElements bad_positions_, bad_normals_;
  RawMesh mesh_;
  std::size_t textures_ = 0;
  bool bad_texture_ = false, bad_color_ = false;
  std::size_t colored_ = 0;
  bool first_line_ = true;
  bool unknown_ = false;
  std::size_t errors_ = 0;
  std::size_t crossing_ = 0;
  SourcePosition first_crossing_;
  std::int64_t polygon_work_ = kMaxPolygonWork;
  std::vector<Corner> corners_;
  std::vector<glm::dvec3> polygon_;
  std::vector<PolygonTriangle> triangles_;
};

/// Numbers of the vertices after the first of their position, found by what these are made of: open addressing over
/// bare numbers, a tenth of what a table of keys would take.
class VertexTable {
 public:
  /// The slot of a vertex: it contains its number, or kNone, to be replaced by one. `is_wanted(n)` tests whether vertex
  /// n is the right one.
  template <typename IsWanted, typename HashOf>
  std::uint32_t& find(std::size_t hash, const IsWanted& is_wanted, const HashOf& hash_of) {
    if (2 * (count_ + 1) > slots_.size()) grow(hash_of);
    std::size_t i = hash & mask();
    while (slots_[i] != kNone && !is_wanted(slots_[i])) i = (i + 1) & mask();
    if (slots_[i] == kNone) ++count_;
    return slots_[i];
  }

 private:
  std::size_t mask() const { return slots_.size() - 1; }

  template <typename HashOf>
  void grow(const HashOf& hash_of) {
    std::vector<std::uint32_t> before(std::max<std::size_t>(1024, 2 * slots_.size()), kNone);
    before.swap(slots_);
    for (const std::uint32_t number : before) {
      if (number == kNone) continue;
      std::size_t i = hash_of(number) & mask();
      while (slots_[i] != kNone) i = (i + 1) & mask();
      slots_[i] = number;
    }
  }

  std::vector<std::uint32_t> slots_;
  std::size_t count_ = 0;
};

/// Turns the index lists of an OBJ file into one: a vertex of the result is a position with a normal and texture
/// coordinates, where there are any. Vertices are numbered first and written out afterwards, list by list, each after
/// the one it came from is freed: the largest file allowed stays within some 3 GiB.
class VertexSplitter {
 public:
  explicit VertexSplitter(RawMesh& raw) : raw_(raw), first_(raw.positions.size(), kNone) {}

  /// Nothing if there would be more than kMaxVertices.
  std::optional<TriangleMesh> split() {
    const bool with_normals = !raw_.normal_triangles.empty();
    with_uv_ = !raw_.uv_triangles.empty();
    mesh_.triangles = std::move(raw_.position_triangles);
    for (std::uint32_t i = 0; i < mesh_.triangles.size(); ++i) {
      for (int corner = 0; corner < 3; ++corner) {
        std::uint32_t& index = mesh_.triangles[i][corner];
        index = number({index, with_normals ? source_of(raw_.normal_triangles[i][corner], i) : 0},
                       with_uv_ ? raw_.uv_triangles[i][corner] : kNone);
        if (vertices_.size() > kMaxVertices) return std::nullopt;
      }
    }
    release(first_);
    further_ = {};
    release(raw_.normal_triangles);
    release(raw_.uv_triangles);
    write_positions();
    if (with_normals) write_normals();
    if (with_uv_) write_uvs();
    return std::move(mesh_);
  }

 private:
  /// The parts of a vertex of the result. `source` is an index into the normals, or kPlane plus the triangle whose
  /// plane gives the normal.
  struct Vertex {
    std::uint32_t position;
    std::uint32_t source;
    bool operator==(const Vertex&) const = default;
  };
  static constexpr std::uint32_t kPlane = 0x80000000u;
  static_assert(kMaxVertices < kPlane && kMaxTriangles < kPlane);

  std::uint32_t source_of(std::uint32_t normal, std::uint32_t triangle) const {
    const bool flat = normal == kNone || raw_.normals[normal] == glm::dvec3(0.0);
    return flat ? kPlane + triangle : normal;
  }

  std::uint32_t number(const Vertex& vertex, std::uint32_t uv) {
    const auto next = static_cast<std::uint32_t>(vertices_.size());
    const auto is_wanted = [&](std::uint32_t n) { return vertices_[n] == vertex && uv_of(n) == uv; };
    // Nearly every position has one normal: the first one is kept in a flat array, only further ones in the table.
    std::uint32_t& first = first_[vertex.position];
    if (first != kNone && is_wanted(first)) return first;
    const auto hash_of = [this](std::uint32_t n) { return mix(vertices_[n], uv_of(n)); };
    std::uint32_t& place = first == kNone ? first : further_.find(mix(vertex, uv), is_wanted, hash_of);
    if (place != kNone) return place;
    place = next;
    vertices_.push_back(vertex);
    if (with_uv_) uv_indices_.push_back(uv);
    return next;
  }

  std::uint32_t uv_of(std::uint32_t vertex) const { return with_uv_ ? uv_indices_[vertex] : kNone; }

  /// Mixed well, because otherwise a file could make all vertices collide.
  static std::size_t mix(const Vertex& v, std::uint32_t uv) {
    const auto stir = [](std::uint64_t x) {
      x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9u;
      x = (x ^ (x >> 27)) * 0x94d049bb133111ebu;
      return x ^ (x >> 31);
    };
    return stir((std::uint64_t{v.position} << 32 | v.source) + stir(uv));
  }

  void write_positions() {
    mesh_.positions.reserve(vertices_.size());
    for (const Vertex& vertex : vertices_) mesh_.positions.push_back(raw_.positions[vertex.position]);
    release(raw_.positions);
    if (raw_.colors.empty()) return;
    mesh_.vertex_colors.reserve(vertices_.size());
    for (const Vertex& vertex : vertices_) mesh_.vertex_colors.push_back(raw_.colors[vertex.position]);
    release(raw_.colors);
  }

  /// A corner without texture coordinates, in a file that has some, gets 0, 0.
  void write_uvs() {
    std::vector<glm::vec2>& uvs = mesh_.uv_sets.emplace_back();
    uvs.reserve(vertices_.size());
    for (const std::uint32_t uv : uv_indices_) uvs.push_back(uv != kNone ? raw_.uvs[uv] : glm::vec2(0.0f));
    release(raw_.uvs);
  }

  void write_normals() {
    mesh_.normals.reserve(vertices_.size());
    for (const Vertex& vertex : vertices_) {
      const bool flat = vertex.source >= kPlane;
      mesh_.normals.push_back(flat ? plane_normal(mesh_.triangles[vertex.source - kPlane])
                                   : raw_.normals[vertex.source]);
    }
    release(raw_.normals);
  }

  glm::dvec3 plane_normal(const glm::uvec3& t) const {
    const glm::dvec3& p = mesh_.positions[t.x];
    const glm::dvec3 n = glm::cross(mesh_.positions[t.y] - p, mesh_.positions[t.z] - p);
    const double length = glm::length(n);
    return length > 0.0 ? n / length
                        : glm::dvec3(0.0, 0.0, 1.0);  // no ray hits a triangle without area: any unit vector will do
  }

  RawMesh& raw_;
  TriangleMesh mesh_;
  bool with_uv_ = false;
  std::vector<Vertex> vertices_;
  std::vector<std::uint32_t> uv_indices_;  ///< of the vertices; empty without texture coordinates
  std::vector<std::uint32_t> first_;       ///< vertex of each position that was made first
  VertexTable further_;
};

}  // namespace

std::optional<TriangleMesh> read_obj(const ByteSource& source, const std::string& file, const MeshContent& content,
                                     Diagnostics& diagnostics, ObjMaterials* materials) {
  if (materials != nullptr) materials->names = {""};
  ObjParser parser(source, file, content, materials, diagnostics);
  if (!parser.parse()) return std::nullopt;
  std::optional<TriangleMesh> mesh = VertexSplitter(parser.mesh()).split();
  if (mesh) {
    warn_degenerate(*mesh, file, diagnostics);
  } else {
    diagnostics.error({file, 0, 0}, fmt::format("the mesh has more than {} vertices with different normals or texture "
                                                "coordinates; split the mesh",
                                                kMaxVertices));
  }
  return mesh;
}

std::optional<TriangleMesh> read_obj(const std::string& path, const MeshContent& content, Diagnostics& diagnostics) {
  InputFile file(path);
  return read_obj([&](char* buffer, std::size_t capacity) { return file.read(buffer, capacity); }, path, content,
                  diagnostics);
}

std::optional<TriangleMesh> read_obj(const std::string& path, const MeshContent& content, ObjMaterials& materials,
                                     Diagnostics& diagnostics) {
  InputFile file(path);
  return read_obj([&](char* buffer, std::size_t capacity) { return file.read(buffer, capacity); }, path, content,
                  diagnostics, &materials);
}

}  // namespace etendue
