#include <cstring>
#include <map>

#include <nanobind/stl/map.h>

#include "module.h"

namespace etendue::python {
namespace {

using Array = nb::ndarray<nb::numpy, const float>;
using Counts = nb::ndarray<nb::numpy, const std::uint32_t>;
using Input = nb::ndarray<const float, nb::shape<-1, -1, 3>, nb::c_contig, nb::device::cpu>;
using InputCounts = nb::ndarray<const std::uint32_t, nb::shape<-1, -1>, nb::c_contig, nb::device::cpu>;

/// Keeps a picture alive as long as an array shows a part of it.
nb::capsule owner_of(const Picture& picture) {
  return nb::capsule(new std::shared_ptr<const Image>(picture.image),
                     [](void* held) noexcept { delete static_cast<std::shared_ptr<const Image>*>(held); });
}

/// An array over values that belong to the picture: height × width × 3, without a copy.
Array colors(const Picture& picture, const std::vector<glm::vec3>& values) {
  static_assert(sizeof(glm::vec3) == 3 * sizeof(float));
  const Image& image = *picture.image;
  return Array(&values.front().x, {image.height, image.width, 3}, owner_of(picture));
}

template <class T>
nb::object plane(const Picture& picture, const std::vector<T>& values) {
  const Image& image = *picture.image;
  return nb::cast(nb::ndarray<nb::numpy, const T>(values.data(), {image.height, image.width}, owner_of(picture)));
}

/// Names and arrays of what is beside the colour.
std::vector<std::pair<std::string, nb::object>> channels(const Picture& picture) {
  std::vector<std::pair<std::string, nb::object>> all;
  for (const ImageChannel& channel : picture.image->channels)
    all.emplace_back(channel.name,
                     channel.numbers.empty() ? plane(picture, channel.values) : plane(picture, channel.numbers));
  return all;
}

std::vector<glm::vec3> copied(const Input& array) {
  std::vector<glm::vec3> values(array.shape(0) * array.shape(1));
  std::memcpy(values.data(), array.data(), values.size() * sizeof(glm::vec3));
  return values;
}

Picture picture_from(const Input& mean, const std::optional<Input>& error, const std::optional<InputCounts>& count) {
  Image image;
  image.height = static_cast<std::uint32_t>(mean.shape(0));
  image.width = static_cast<std::uint32_t>(mean.shape(1));
  image.pixels = copied(mean);
  if (image.pixels.empty()) throw Error(ErrorKind::usage, "A picture has at least one pixel; this array has none.");
  const auto check = [&](std::size_t height, std::size_t width, const char* what) {
    if (height == image.height && width == image.width) return;
    throw Error(ErrorKind::usage, std::string("The ") + what + " has " + std::to_string(width) + "x" +
                                      std::to_string(height) + " pixels, the mean " + std::to_string(image.width) +
                                      "x" + std::to_string(image.height) + ".");
  };
  if (error) {
    check(error->shape(0), error->shape(1), "standard error");
    image.standard_error = copied(*error);
  }
  if (count) {
    check(count->shape(0), count->shape(1), "sample count");
    image.sample_count.assign(count->data(), count->data() + image.pixels.size());
  }
  return Picture(std::move(image));
}

Display display_of(const std::string& tonemap, double exposure) {
  for (const std::string& name : tone_map_names()) {
    if (name == tonemap) return {.tone_map = tone_map_of(tonemap), .exposure = exposure};
  }
  std::string names;
  for (const std::string& name : tone_map_names()) names += (names.empty() ? "" : ", ") + name;
  throw Error(ErrorKind::usage, "There is no tone curve '" + tonemap + "'; there are: " + names + ".");
}

const FilmFile& film_of(const Picture& picture) {
  if (!picture.film)
    throw Error(ErrorKind::usage, "This picture is no film: only what render() or read_film() gives has exact sums.");
  return *picture.film;
}

void write_picture(const Picture& picture, const std::string& path, bool film, const std::string& tonemap,
                   double exposure) {
  const bool exr = path.ends_with(".exr");
  if (!exr && !path.ends_with(".png"))
    throw Error(ErrorKind::usage, "'" + path + "' ends neither in .exr nor in .png, the only formats for pictures.");
  const Display display = display_of(tonemap, exposure);
  if (film && !exr) throw Error(ErrorKind::usage, "'" + path + "': films are .exr files.");
  if (film) film_of(picture);
  run_waiting([&] {
    if (film) return write_film(path, *picture.film);
    exr ? write_exr(path, *picture.image) : write_png(path, *picture.image, display);
  });
}

nb::bytes png_of(const Picture& picture, const std::string& tonemap, double exposure) {
  const Display display = display_of(tonemap, exposure);
  std::vector<std::byte> bytes;
  {
    const nb::gil_scoped_release working;
    bytes = encode_png(*picture.image, display);
  }
  return nb::bytes(bytes.data(), bytes.size());
}

Picture read_picture(const std::string& path, bool film) {
  std::optional<Picture> picture;
  run_waiting([&] {
    if (film) {
      picture.emplace(read_film(path));
    } else {
      picture.emplace(read_image(path));
    }
  });
  return *picture;
}

Picture merge(const std::vector<Picture>& pictures) {
  std::vector<const FilmFile*> films;
  for (const Picture& picture : pictures) films.push_back(&film_of(picture));
  std::optional<Picture> merged;
  run_waiting([&] { merged.emplace(merge_loaded_films(films)); });
  return *merged;
}

Picture denoise(const Picture& picture, const std::string& library) {
  std::optional<Picture> without;
  run_waiting([&] { without.emplace(Denoiser(library).denoise(*picture.image, "the picture")); });
  return *without;
}

}  // namespace

void bind_pictures(nb::module_& m) {
  nb::class_<Picture>(m, "Picture")
      .def_static("from_arrays", &picture_from, nb::arg("mean"), nb::arg("standard_error").none(),
                  nb::arg("sample_count").none())
      .def_prop_ro("width", [](const Picture& p) { return p.image->width; })
      .def_prop_ro("height", [](const Picture& p) { return p.image->height; })
      // The arrays have an owner: the default policy, to keep this object alive for them, is not needed.
      .def_prop_ro(
          "mean", [](const Picture& p) { return colors(p, p.image->pixels); }, nb::rv_policy::reference)
      .def_prop_ro(
          "standard_error",
          [](const Picture& p) {
            const std::vector<glm::vec3>& error = p.image->standard_error;
            return error.empty() ? std::nullopt : std::optional(colors(p, error));
          },
          nb::rv_policy::reference)
      .def_prop_ro(
          "sample_count",
          [](const Picture& p) { return p.image->sample_count.empty() ? nb::none() : plane(p, p.image->sample_count); })
      .def_prop_ro("channels", &channels)
      .def_prop_ro("metadata", [](const Picture& p) { return p.image->metadata; })
      .def_prop_ro("is_film", [](const Picture& p) { return p.film != nullptr; })
      .def_prop_ro("samples", [](const Picture& p) { return film_of(p).samples; })
      .def_prop_ro("rejected", [](const Picture& p) { return film_of(p).film.rejected(); })
      .def("write", &write_picture, nb::arg("path"), nb::arg("film"), nb::arg("tonemap"), nb::arg("exposure"))
      .def("png", &png_of, nb::arg("tonemap"), nb::arg("exposure"));
  m.def("read_picture", &read_picture, nb::arg("path"), nb::arg("film"));
  m.def("merge", &merge, nb::arg("pictures"));
  m.def("denoise", &denoise, nb::arg("picture"), nb::arg("library"));
  m.def(
      "read_noisy_picture",
      [](const std::string& path) {
        std::optional<Picture> picture;
        run_waiting([&] { picture.emplace(read_noisy_picture(path)); });
        return *picture;
      },
      nb::arg("path"));
}

}  // namespace etendue::python
