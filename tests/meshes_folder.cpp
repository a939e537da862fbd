/// Linked into tests that read the scenes of Etendue: their programs do not lie where etendue does in the build tree,
/// so they are told where the build makes meshes and pictures for scenes.

#include <cstdlib>

namespace {

[[maybe_unused]] const int set = ::setenv("ETENDUE_MESHES", MESHES_DIR, 0);

}  // namespace
