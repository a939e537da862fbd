#pragma once
/// Scenes: read from a file, or put together in memory.
///
/// `Scene` is a plain struct of tables: fill it, by `add` for instance, and hand it to a renderer, which refuses what
/// breaks an invariant. read_scene() makes one of a file, read_scene_objects() one
/// of objects in memory.

#include "formats/read_scene.h"
#include "formats/scene_objects.h"
#include "scene/check.h"
#include "scene/film_projection.h"
#include "scene/invariants.h"
#include "scene/material_numbers.h"
#include "scene/parameters.h"
#include "scene/scene.h"
