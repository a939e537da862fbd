#pragma once
/// Scenes: read from a file, or built in memory.
///
/// `Scene` is a plain struct of tables: fill it, for instance with `add`, and pass it to a renderer, which refuses
/// scenes that violate an invariant. read_scene() makes one from a file, read_scene_objects() from objects in memory.

#include "formats/read_scene.h"
#include "formats/scene_objects.h"
#include "scene/check.h"
#include "scene/film_projection.h"
#include "scene/invariants.h"
#include "scene/material_numbers.h"
#include "scene/parameters.h"
#include "scene/scene.h"
