#pragma once
/// Scenes: read from a file, or put together in memory.
///
/// `Scene` is a plain struct of tables: fill it, by `add` for instance, and hand it to a renderer, which refuses what
/// breaks an invariant. read_scene() makes one of a file.

#include "formats/read_scene.h"
#include "scene/invariants.h"
#include "scene/scene.h"
