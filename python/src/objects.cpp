/// Scenes of objects: what load_dict() hands over.

#include <cstring>

#include "module.h"

namespace etendue::python {
namespace {

template <class T, int Columns>
using Rows = nb::ndarray<const T, nb::shape<-1, Columns>, nb::c_contig, nb::device::cpu>;
using Matrix = nb::ndarray<const double, nb::shape<4, 4>, nb::c_contig, nb::device::cpu>;

/// The rows of an array as vectors, copied as a whole.
template <class Vector, class Array>
std::vector<Vector> vectors(const Array& array) {
  static_assert(sizeof(Vector) == Vector::length() * sizeof(typename Array::Scalar));
  std::vector<Vector> all(array.shape(0));
  if (!all.empty()) std::memcpy(all.data(), array.data(), all.size() * sizeof(Vector));
  return all;
}

void set_mesh(SceneObject& object, const Rows<double, 3>& positions, const Rows<std::uint32_t, 3>& triangles,
              const std::optional<Rows<double, 3>>& normals, const std::optional<Rows<float, 2>>& uvs,
              const std::optional<Rows<float, 3>>& colors) {
  TriangleMesh mesh;
  mesh.positions = vectors<glm::dvec3>(positions);
  mesh.triangles = vectors<glm::uvec3>(triangles);
  if (normals) mesh.normals = vectors<glm::dvec3>(*normals);
  for (glm::dvec3& normal : mesh.normals.edit()) normal = glm::normalize(normal);
  if (uvs) mesh.uv_sets.push_back(vectors<glm::vec2>(*uvs));
  if (colors) mesh.vertex_colors = vectors<glm::vec3>(*colors);
  object.mesh = std::move(mesh);
}

/// `bytes`: height × width × channels of one-byte sRGB codes, or of linear 32-bit floats.
void set_bitmap(SceneObject& object, const nb::bytes& bytes, std::uint32_t width, std::uint32_t height,
                std::uint32_t channels, bool codes) {
  Bitmap bitmap{.width = width,
                .height = height,
                .channels = channels,
                .format = codes ? BitmapFormat::u8 : BitmapFormat::f32,
                .color_space = codes ? ColorSpace::srgb : ColorSpace::linear,
                .texels = {}};
  const auto* begin = static_cast<const std::byte*>(bytes.data());
  bitmap.texels.assign(begin, begin + bytes.size());
  if (bitmap.texels.size() != bitmap.row_bytes() * height)
    throw Error(ErrorKind::usage, "A bitmap has other bytes than its size says.");
  object.bitmap = std::move(bitmap);
}

SceneHolder read_objects(SceneObject& root, bool strict, bool approximate) {
  const ReadOptions options{.strict = strict, .approximate = approximate};
  Diagnostics diagnostics;
  std::optional<Scene> scene;
  run_waiting([&] {
    scene = read_scene_objects(std::move(root), options, diagnostics);
    if (scene) check_scene(*scene, diagnostics);
    diagnostics.log_warnings();
  });
  if (!scene || diagnostics.has_errors()) throw ReadFailure(diagnostics.list());
  return SceneHolder(std::move(*scene), diagnostics.list());
}

template <class T>
void add(SceneObject& object, const std::string& name, T value) {
  object.properties.emplace_back(name, std::move(value));
}

}  // namespace

void bind_objects(nb::module_& m) {
  nb::class_<SceneObject>(m, "SceneObject")
      .def(nb::init<>())
      .def_rw("type", &SceneObject::type)
      .def("add_bool", &add<bool>, nb::arg("name"), nb::arg("value"))
      .def("add_int", &add<std::int64_t>, nb::arg("name"), nb::arg("value"))
      .def("add_float", &add<double>, nb::arg("name"), nb::arg("value"))
      .def("add_text", &add<std::string>, nb::arg("name"), nb::arg("value"))
      .def("add_numbers", &add<std::vector<double>>, nb::arg("name"), nb::arg("value"))
      .def(
          "add_matrix",
          [](SceneObject& object, const std::string& name, const Matrix& rows) {
            glm::dmat4 matrix;
            for (int i = 0; i < 16; ++i) matrix[i % 4][i / 4] = rows.data()[i];
            add(object, name, matrix);
          },
          nb::arg("name"), nb::arg("value"))
      .def(
          "add_object",
          [](SceneObject& object, const std::string& name, SceneObject& held) {
            add(object, name, std::make_shared<SceneObject>(std::move(held)));
          },
          nb::arg("name"), nb::arg("value"))
      .def("set_mesh", &set_mesh, nb::arg("positions"), nb::arg("triangles"), nb::arg("normals").none(),
           nb::arg("uvs").none(), nb::arg("colors").none())
      .def("set_bitmap", &set_bitmap, nb::arg("data"), nb::arg("width"), nb::arg("height"), nb::arg("channels"),
           nb::arg("codes"));
  m.def("read_objects", &read_objects, nb::arg("root"), nb::arg("strict"), nb::arg("approximate"));
}

}  // namespace etendue::python
