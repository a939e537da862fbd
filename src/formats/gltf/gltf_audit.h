#pragma once
/// Looks for what the standard forbids in assets that can be shown all the same.

namespace etendue {

class Diagnostics;
class GltfDocument;

/// Reports a warning for each such place in an asset that has been read; it says what was done instead.
void audit_gltf(const GltfDocument& document, Diagnostics& diagnostics);

}  // namespace etendue
