/// A library with the functions of Open Image Denoise that Etendue calls. It writes what it is asked to the file
/// FAKE_OIDN_LOG, and makes of every picture something that a test can compute. FAKE_OIDN says what is wrong with it:
/// "old", "no device", "no filter" or "fails".

#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <map>
#include <string>

namespace {

struct Picture {
  float* values = nullptr;
  std::size_t width = 0, height = 0;
};

struct FakeFilter {
  std::map<std::string, Picture> pictures;
  bool committed = false;
};

bool is(const char* fault) {
  const char* wanted = std::getenv("FAKE_OIDN");
  return wanted != nullptr && std::strcmp(wanted, fault) == 0;
}

template <typename... Values>
void note(const char* format, Values... values) {
  const char* path = std::getenv("FAKE_OIDN_LOG");
  FILE* file = path == nullptr ? nullptr : std::fopen(path, "a");
  if (file == nullptr) return;
  std::fprintf(file, format, values...);
  std::fclose(file);
}

int g_device = 0;  // its address is the device
int g_error = 0;

}  // namespace

#pragma GCC visibility push(default)
extern "C" {

void* oidnNewDevice(int type) {
  note("device %d\n", type);
  if (is("no device")) return nullptr;
  return &g_device;
}

void oidnCommitDevice(void* device) {
  note("commit device %d\n", device == &g_device);
}

int oidnGetDeviceInt(void*, const char* name) {
  note("int %s\n", name);
  return is("old") ? 10403 : 20304;
}

int oidnGetDeviceError(void*, const char** message) {
  const int error = g_error;
  g_error = 0;
  *message = error == 0 ? nullptr : "out of\x1b[31m patience";
  return error;
}

void oidnReleaseDevice(void* device) {
  note("release device %d\n", device == &g_device);
}

void* oidnNewFilter(void* device, const char* type) {
  note("filter %d %s\n", device == &g_device, type);
  return is("no filter") ? nullptr : new FakeFilter;
}

void oidnSetSharedFilterImage(FakeFilter* filter, const char* name, void* values, int format, std::size_t width,
                              std::size_t height, std::size_t byte_offset, std::size_t pixel_byte_stride,
                              std::size_t row_byte_stride) {
  note("image %s format %d size %zux%zu offset %zu strides %zu %zu\n", name, format, width, height, byte_offset,
       pixel_byte_stride, row_byte_stride);
  filter->pictures[name] = {static_cast<float*>(values), width, height};
}

void oidnSetFilterBool(FakeFilter*, const char* name, bool value) {
  note("bool %s %d\n", name, value);
}

void oidnCommitFilter(FakeFilter* filter) {
  note("commit filter\n");
  filter->committed = true;
}

// Twice the colour, and the guides as they are.
void oidnExecuteFilter(FakeFilter* filter) {
  note("execute %d\n", filter->committed);
  if (is("fails")) {
    g_error = 4;
    return;
  }
  const Picture& out = filter->pictures["output"];
  for (std::size_t i = 0; i < 3 * out.width * out.height; ++i) {
    out.values[i] = 2 * filter->pictures["color"].values[i];
    for (const char* guide : {"albedo", "normal"}) {
      const Picture& picture = filter->pictures[guide];
      if (picture.values != nullptr) out.values[i] += picture.values[i];
    }
  }
}

void oidnReleaseFilter(FakeFilter* filter) {
  note("release filter\n");
  delete filter;
}
}
#pragma GCC visibility pop
