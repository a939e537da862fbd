#include "formats/ply/ply_reader.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <span>
#include <string_view>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "core/memory.h"
#include "core/text.h"
#include "formats/input_file.h"
#include "formats/mesh/polygon.h"
#include "formats/ply/ply_header.h"
#include "formats/ply/ply_stream.h"
#include "scene/limits.h"

namespace etendue {
namespace {

/// Numbers of a vertex or a face that the reader keeps.
enum Slot : std::size_t { kX, kY, kZ, kNx, kNy, kNz, kU, kV, kTx, kTy, kTz, kTw, kRed, kGreen, kBlue, kAlpha, kSlots };
constexpr int kUnwanted = -1;
constexpr std::array kPositionSlots = {kX, kY, kZ};
constexpr std::array kNormalSlots = {kNx, kNy, kNz};
constexpr std::array kUvSlots = {kU, kV};
constexpr std::array kTangentSlots = {kTx, kTy, kTz, kTw};
constexpr std::array kColorSlots = {kRed, kGreen, kBlue};
constexpr std::array kAlphaSlots = {kAlpha};

struct SlotName {
  const char* name;
  Slot slot;
};
/// Names that programs give them.
constexpr SlotName kSlotNames[] = {{"x", kX},
                                   {"y", kY},
                                   {"z", kZ},
                                   {"nx", kNx},
                                   {"ny", kNy},
                                   {"nz", kNz},
                                   {"u", kU},
                                   {"v", kV},
                                   {"s", kU},
                                   {"t", kV},
                                   {"texture_u", kU},
                                   {"texture_v", kV},
                                   {"texture_s", kU},
                                   {"texture_t", kV},
                                   {"tangent_x", kTx},
                                   {"tangent_y", kTy},
                                   {"tangent_z", kTz},
                                   {"tangent_w", kTw},
                                   {"red", kRed},
                                   {"green", kGreen},
                                   {"blue", kBlue},
                                   {"r", kRed},
                                   {"g", kGreen},
                                   {"b", kBlue},
                                   {"color_0", kRed},
                                   {"color_1", kGreen},
                                   {"color_2", kBlue},
                                   {"color_3", kAlpha},
                                   {"diffuse_red", kRed},
                                   {"diffuse_green", kGreen},
                                   {"diffuse_blue", kBlue}};

/// An element as it will be read: where its numbers go.
struct Layout {
  const PlyElement* element;
  std::vector<int> slots;  ///< of each property: a Slot or kUnwanted
  std::array<bool, kSlots> present{};
  int corners = kUnwanted;   ///< the property that lists vertex indices
  bool grey = false;         ///< one number stands for three
  double color_scale = 0.0;  ///< of integer colours: 1 / largest; 0 where they are linear floats

  template <std::size_t N>
  bool has(const std::array<Slot, N>& group) const {
    return std::ranges::all_of(group, [&](Slot slot) { return present[slot]; });
  }
};

template <std::size_t N>
void drop_unless_whole(Layout& layout, const std::array<Slot, N>& group, bool wanted) {
  if (wanted && layout.has(group)) return;
  for (const Slot slot : group) {
    layout.present[slot] = false;
    std::ranges::replace(layout.slots, static_cast<int>(slot), kUnwanted);
  }
}

Layout make_layout(const PlyElement& element, bool is_face, const MeshContent& content) {
  Layout layout{.element = &element, .slots = {}};
  for (const PlyProperty& property : element.properties) {
    layout.slots.push_back(kUnwanted);
    const bool lists_corners = property.name == "vertex_indices" || property.name == "vertex_index";
    if (property.count_type) {
      if (lists_corners) layout.corners = static_cast<int>(layout.slots.size()) - 1;
      continue;
    }
    if (!content.attribute.empty()) {
      for (const Slot slot : kColorSlots) {
        if (property.name != fmt::format("{}_{}", content.attribute, slot - kRed)) continue;
        layout.present[slot] = true;
        layout.slots.back() = static_cast<int>(slot);
      }
    }
    for (const SlotName& row : kSlotNames) {
      if (property.name != row.name || layout.present[row.slot]) continue;
      if (row.slot >= kRed && !content.attribute.empty()) continue;
      layout.present[row.slot] = true;
      layout.slots.back() = static_cast<int>(row.slot);
      if (row.slot == kRed && is_integer(property.type)) layout.color_scale = 1.0 / largest_of(property.type);
    }
  }
  layout.grey = layout.present[kRed] && !layout.present[kGreen] && !layout.present[kBlue] && !content.attribute.empty();
  if (layout.grey) layout.present[kGreen] = layout.present[kBlue] = true;
  drop_unless_whole(layout, kPositionSlots, !is_face);
  drop_unless_whole(layout, kNormalSlots, !is_face);
  drop_unless_whole(layout, kUvSlots, !is_face && content.uv);
  drop_unless_whole(layout, kTangentSlots, !is_face && content.tangents);
  drop_unless_whole(layout, kColorSlots, content.colors);
  drop_unless_whole(layout, kAlphaSlots, !is_face && layout.has(kColorSlots) && layout.color_scale == 0.0);
  return layout;
}

using Numbers = std::array<double, kSlots>;

class PlyReader {
 public:
  PlyReader(const ByteSource& source, const std::string& file, const MeshContent& content, Diagnostics& diagnostics,
            std::uint64_t bytes)
      : stream_(source, file), file_(file), content_(content), diagnostics_(diagnostics), bytes_(bytes) {}

  /// Nothing after a reported error.
  std::optional<TriangleMesh> read() {
    try {
      const PlyHeader header = read_ply_header(stream_, diagnostics_);
      for (const PlyElement& element : header.elements) read_element(element);
      if (!vertices_read_) throw PlyError{{file_, 0, 0}, "the file has no element \"vertex\" and so no surface"};
      cut_polygons();
    } catch (const PlyError& error) {
      diagnostics_.error(error.position, error.message);
      return std::nullopt;
    }
    finish();
    return std::move(mesh_);
  }

 private:
  void read_element(const PlyElement& element) {
    if (element.properties.empty()) return;  // nothing of it is in the file, however many there are said to be
    if (element.name == "vertex") return read_vertices(element);
    if (element.name == "face") return read_faces(element);
    if (element.name == "tristrips") return read_strips(element);
    const Layout layout{.element = &element, .slots = std::vector<int>(element.properties.size(), kUnwanted)};
    Numbers numbers{};
    for (std::uint64_t i = 0; i < element.count; ++i) read_numbers(layout, numbers);
  }

  /// Reads one element but for the list of its corners, which the reader of faces takes where it stands.
  template <typename ReadCorners>
  void read_numbers(const Layout& layout, Numbers& numbers, const ReadCorners& read_corners) {
    const std::vector<PlyProperty>& properties = layout.element->properties;
    for (std::size_t i = 0; i < properties.size(); ++i) {
      const PlyProperty& property = properties[i];
      if (property.count_type) {
        const std::int64_t count = stream_.read_integer(*property.count_type);
        if (count < 0) stream_.fail(fmt::format("the list {} has {} items", text::quoted(property.name), count));
        if (static_cast<int>(i) == layout.corners) {
          read_corners(property.type, static_cast<std::uint64_t>(count));
        } else {
          stream_.skip(property.type, static_cast<std::uint64_t>(count));
        }
      } else if (layout.slots[i] == kUnwanted) {
        stream_.skip(property.type, 1);
      } else {
        numbers[static_cast<std::size_t>(layout.slots[i])] = stream_.read(property.type);
      }
    }
  }
  void read_numbers(const Layout& layout, Numbers& numbers) {
    read_numbers(layout, numbers, [this](PlyType type, std::uint64_t count) { stream_.skip(type, count); });
  }

  void read_vertices(const PlyElement& element) {
    if (element.count > kMaxVertices)
      throw PlyError{element.position,
                     fmt::format("the file has {} vertices; at most {} are supported", element.count, kMaxVertices)};
    const Layout layout = make_layout(element, false, content_);
    if (!layout.has(kPositionSlots))
      throw PlyError{element.position, "the vertices lack a coordinate; they need the properties x, y and z"};
    reserve_vertices(layout);
    Numbers numbers{};
    if (stream_.is_binary() && !element.has_lists() && element.least_size() <= PlyStream::kMaxRun) {
      read_binary_vertices(layout);
    } else {
      for (std::uint64_t i = 0; i < element.count; ++i) {
        read_numbers(layout, numbers);
        add_vertex(layout, numbers);
      }
    }
    vertices_read_ = true;
  }

  /// Vertices of one size, each in one piece.
  void read_binary_vertices(const Layout& layout) {
    struct Field {
      PlyType type;
      std::size_t offset, slot;
    };
    std::vector<Field> fields;
    std::size_t size = 0;
    for (std::size_t i = 0; i < layout.slots.size(); ++i) {
      const PlyType type = layout.element->properties[i].type;
      if (layout.slots[i] != kUnwanted) fields.push_back({type, size, static_cast<std::size_t>(layout.slots[i])});
      size += size_of(type);
    }
    Numbers numbers{};
    for (std::uint64_t i = 0; i < layout.element->count; ++i) {
      const char* bytes = stream_.take(size);
      for (const Field& field : fields) numbers[field.slot] = stream_.decode(field.type, bytes + field.offset);
      add_vertex(layout, numbers);
    }
  }

  /// Room for as many as the file can hold.
  std::size_t room_for(const PlyElement& element) const {
    const std::size_t least = stream_.is_binary() ? element.least_size() : 2 * element.properties.size();
    return static_cast<std::size_t>(std::min(element.count, bytes_ / least));
  }

  void reserve_vertices(const Layout& layout) {
    const std::size_t room = room_for(*layout.element);
    mesh_.positions.reserve(room);
    if (layout.has(kNormalSlots)) mesh_.normals.reserve(room);
    if (layout.has(kColorSlots)) mesh_.vertex_colors.reserve(room);
    if (!layout.has(kUvSlots)) return;
    mesh_.uv_sets.emplace_back();
    mesh_.uv_sets[0].reserve(room);
  }

  void add_vertex(const Layout& layout, const Numbers& n) {
    mesh_.positions.emplace_back(n[kX], n[kY], n[kZ]);
    if (layout.present[kNx]) mesh_.normals.push_back(unit_or_zero({n[kNx], n[kNy], n[kNz]}));
    if (layout.present[kU]) mesh_.uv_sets[0].emplace_back(n[kU], n[kV]);
    if (layout.present[kTx]) mesh_.tangents.emplace_back(n[kTx], n[kTy], n[kTz], n[kTw]);
    if (layout.present[kRed]) mesh_.vertex_colors.push_back(color_of(layout, n));
    if (layout.present[kAlpha]) mesh_.vertex_alphas.push_back(static_cast<float>(n[kAlpha]));
  }

  static glm::dvec3 unit_or_zero(const glm::dvec3& n) {
    constexpr double kRounding = 1e-15;
    if (std::abs(glm::dot(n, n) - 1.0) <= kRounding) return n;  // to be the same again in a file that we wrote
    const double largest = std::max({std::abs(n.x), std::abs(n.y), std::abs(n.z)});
    return largest > 0.0 && std::isfinite(n.x + n.y + n.z) ? glm::normalize(n / largest) : glm::dvec3(0.0);
  }

  static glm::vec3 color_of(const Layout& layout, const Numbers& n) {
    const glm::dvec3 color = layout.grey ? glm::dvec3(n[kRed]) : glm::dvec3(n[kRed], n[kGreen], n[kBlue]);
    return layout.color_scale > 0.0 ? linear_from_srgb(glm::vec3(color * layout.color_scale)) : glm::vec3(color);
  }

  void read_faces(const PlyElement& element) {
    const Layout layout = make_layout(element, true, content_);
    if (layout.corners == kUnwanted)
      throw PlyError{element.position, "the faces lack their corners; they need a list \"vertex_indices\""};
    if (element.count > kMaxTriangles)
      throw PlyError{element.position,
                     fmt::format("the file has {} faces; at most {} are supported", element.count, kMaxTriangles)};
    for (const PlyProperty& property : element.properties) {
      if (property.name == "texcoord" && content_.uv)
        diagnostics_.warning(
            element.position,
            "texture coordinates of the corners of faces (texcoord) are not read; export them with the vertices");
    }
    mesh_.triangles.reserve(room_for(element));
    Numbers numbers{};
    for (std::uint64_t i = 0; i < element.count; ++i) {
      read_numbers(layout, numbers, [this](PlyType type, std::uint64_t count) { read_corners(type, count); });
      face_color_ = layout.present[kRed] ? std::optional(color_of(layout, numbers)) : std::nullopt;
      add_face();
    }
  }

  void read_corners(PlyType type, std::uint64_t count) {
    if (count > kMaxCorners)
      stream_.fail(fmt::format("a face has {} corners; at most {} are supported: triangulate it", count, kMaxCorners));
    corners_.clear();
    for (; count > 0; --count) corners_.push_back(checked_index(stream_.read(type)));
  }

  std::uint32_t checked_index(double value) const {
    const double end = vertices_read_ ? static_cast<double>(mesh_.positions.size()) : double{kMaxVertices};
    if (value >= 0.0 && value < end && value == std::floor(value)) return static_cast<std::uint32_t>(value);
    stream_.fail(fmt::format("a face has vertex {}; {}", value,
                             vertices_read_ ? fmt::format("the file has {}", mesh_.positions.size())
                                            : fmt::format("vertices are numbered from 0 to {}", kMaxVertices - 1)));
  }

  /// Strips of triangles; a negative index begins a new one.
  void read_strips(const PlyElement& element) {
    const Layout layout = make_layout(element, true, content_);
    if (layout.corners == kUnwanted)
      throw PlyError{element.position, "the strips lack their corners; they need a list \"vertex_indices\""};
    face_color_.reset();
    Numbers numbers{};
    for (std::uint64_t i = 0; i < element.count; ++i)
      read_numbers(layout, numbers, [this](PlyType type, std::uint64_t count) { read_strip(type, count); });
  }

  void read_strip(PlyType type, std::uint64_t count) {
    std::uint32_t a = 0, b = 0;
    for (std::uint64_t length = 0; count > 0; --count) {
      const double value = stream_.read(type);
      if (value < 0.0) {
        length = 0;
        continue;
      }
      const std::uint32_t c = checked_index(value);
      // Strips turn every other triangle around, and repeat a vertex where they go on elsewhere.
      if (length >= 2 && a != b && b != c && c != a)
        add_triangle(length % 2 == 0 ? glm::uvec3(a, b, c) : glm::uvec3(b, a, c));
      a = b;
      b = c;
      ++length;
    }
  }

  /// Polygons wait until the vertices are known: they are cut where these lie.
  void add_face() {
    if (corners_.size() < 3) {
      ++small_faces_;
      return;
    }
    if (corners_.size() > 3 && !vertices_read_) {
      waiting_.push_back({mesh_.triangles.size(), waiting_corners_.size(), corners_.size()});
      waiting_corners_.insert(waiting_corners_.end(), corners_.begin(), corners_.end());
      for (std::size_t i = 2; i < corners_.size(); ++i) add_triangle({0, 0, 0});
      return;
    }
    if (corners_.size() == 3) return add_triangle({corners_[0], corners_[1], corners_[2]});
    cut(corners_);
    for (const PolygonTriangle& t : cut_) add_triangle({corners_[t.x], corners_[t.y], corners_[t.z]});
  }

  void add_triangle(const glm::uvec3& triangle) {
    if (mesh_.triangles.size() == kMaxTriangles)
      throw PlyError{{file_, 0, 0}, fmt::format("the file has more than {} triangles; split the mesh", kMaxTriangles)};
    mesh_.triangles.push_back(triangle);
    if (face_color_) mesh_.face_colors.push_back(*face_color_);
  }

  /// Into cut_, as many triangles as corners but two.
  void cut(std::span<const std::uint32_t> corners) {
    polygon_.clear();
    cut_.clear();
    for (const std::uint32_t corner : corners) {
      check_vertex(corner);
      polygon_.push_back(mesh_.positions[corner]);
    }
    if (triangulate(polygon_, cut_, polygon_work_)) return;
    if (polygon_work_ <= 0)
      throw PlyError{{file_, 0, 0},
                     "the concave faces of this file are too large to triangulate here; triangulate them on export"};
    ++crossing_;
  }

  /// What waited for its vertices.
  void cut_polygons() {
    for (const glm::uvec3& t : mesh_.triangles) {
      for (int i = 0; i < 3; ++i) check_vertex(t[i]);
    }
    for (std::size_t i = 0; i < mesh_.face_colors.size(); ++i) check_color(mesh_.face_colors[i], "triangle", i);
    for (const Waiting& face : waiting_) {
      const std::span corners(waiting_corners_.data() + face.first_corner, face.corners);
      cut(corners);
      for (std::size_t i = 0; i < cut_.size(); ++i)
        mesh_.triangles[face.first_triangle + i] = {corners[cut_[i].x], corners[cut_[i].y], corners[cut_[i].z]};
    }
  }

  /// That a face uses it: what no face uses may hold anything.
  void check_vertex(std::uint32_t vertex) const {
    if (vertex >= mesh_.positions.size())
      throw PlyError{{file_, 0, 0},
                     fmt::format("a face has vertex {}; the file has {}", vertex, mesh_.positions.size())};
    const glm::dvec3& p = mesh_.positions[vertex];
    if (!(std::max({std::abs(p.x), std::abs(p.y), std::abs(p.z)}) <= kMaxCoordinate) || std::isnan(p.x + p.y + p.z))
      throw PlyError{{file_, 0, 0},
                     fmt::format("vertex {} is at {} {} {}; coordinates up to {} are supported", vertex, p.x, p.y, p.z,
                                 kMaxCoordinate)};
    if (!mesh_.uv_sets.empty() && !std::isfinite(mesh_.uv_sets[0][vertex].x + mesh_.uv_sets[0][vertex].y))
      throw PlyError{{file_, 0, 0},
                     fmt::format("vertex {} has texture coordinates {} {}; they must be finite", vertex,
                                 mesh_.uv_sets[0][vertex].x, mesh_.uv_sets[0][vertex].y)};
    if (!mesh_.vertex_colors.empty()) check_color(mesh_.vertex_colors[vertex], "vertex", vertex);
    if (!mesh_.vertex_alphas.empty()) check_color(glm::vec3(mesh_.vertex_alphas[vertex]), "vertex", vertex);
  }

  void check_color(const glm::vec3& c, const char* what, std::size_t index) const {
    if (std::isfinite(c.x + c.y + c.z)) return;
    throw PlyError{{file_, 0, 0},
                   fmt::format("{} {} has the colour {} {} {}; it must be finite", what, index, c.x, c.y, c.z)};
  }

  void finish() {
    const auto warn = [&](std::size_t count, const char* what) {
      if (count > 0) diagnostics_.warning({file_, 0, 0}, fmt::format("{} {}", count, what));
    };
    drop_unused_vertices(mesh_);
    if (!mesh_.face_colors.empty() && mesh_.face_colors.size() != mesh_.triangles.size()) {
      warn(mesh_.triangles.size() - mesh_.face_colors.size(),
           "triangles have no colour; those of the others are left out");
      mesh_.face_colors.clear();
    }
    warn(small_faces_, "faces have fewer than 3 corners; they are left out");
    warn(crossing_, "polygons cross themselves; their triangles overlap");
    fill_normals();
    warn_degenerate(mesh_, file_, diagnostics_);
  }

  /// Normals without a direction become the mean of the faces around.
  void fill_normals() {
    const auto lacking = std::ranges::count(mesh_.normals, glm::dvec3(0.0));
    if (lacking == 0) return;
    diagnostics_.warning({file_, 0, 0},
                         fmt::format("{} of {} vertex normals have no direction; {}", lacking, mesh_.normals.size(),
                                     lacking == std::ssize(mesh_.normals) ? "the faces' own are taken instead"
                                                                          : "the mean of the faces around is taken"));
    const VectorList given = std::exchange(mesh_.normals, {});
    if (lacking == std::ssize(given)) return;
    make_smooth_normals(mesh_);
    std::vector<glm::dvec3>& normals = mesh_.normals.edit();
    for (std::size_t i = 0; i < given.size(); ++i) {
      if (given[i] != glm::dvec3(0.0)) normals[i] = given[i];
    }
  }

  /// A polygon whose triangles have their places already.
  struct Waiting {
    std::size_t first_triangle, first_corner, corners;
  };

  PlyStream stream_;
  const std::string& file_;
  MeshContent content_;
  Diagnostics& diagnostics_;
  std::uint64_t bytes_;
  TriangleMesh mesh_;
  bool vertices_read_ = false;
  std::vector<std::uint32_t> corners_;  ///< of the face that is being read
  std::optional<glm::vec3> face_color_;
  std::vector<Waiting> waiting_;
  std::vector<std::uint32_t> waiting_corners_;
  std::vector<glm::dvec3> polygon_;
  std::vector<PolygonTriangle> cut_;
  std::int64_t polygon_work_ = kMaxPolygonWork;
  std::size_t crossing_ = 0, small_faces_ = 0;
};

}  // namespace

std::optional<TriangleMesh> read_ply(const ByteSource& source, const std::string& file, const MeshContent& content,
                                     Diagnostics& diagnostics, std::uint64_t bytes) {
  return PlyReader(source, file, content, diagnostics, bytes).read();
}

std::optional<TriangleMesh> read_ply(const std::string& path, const MeshContent& content, Diagnostics& diagnostics) {
  InputFile file(path);
  return read_ply([&](char* buffer, std::size_t capacity) { return file.read(buffer, capacity); }, path, content,
                  diagnostics, file.size());
}

}  // namespace etendue
