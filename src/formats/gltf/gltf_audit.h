#pragma once
/// Looks for what the standard forbids in assets that can be shown all the same.

namespace etendue {

class Accessors;
class Diagnostics;
class GltfDocument;

/// Reports a warning for each such place in an asset that has been read without errors. `with_animations`: whether
/// no animation was read, so that all of them are checked here.
void audit_gltf(GltfDocument& document, Accessors& accessors, bool with_animations, Diagnostics& diagnostics);

}  // namespace etendue
