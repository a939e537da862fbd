#pragma once
/// Etendue as a library.
///
///     const etendue::Scene scene = etendue::read_scene("cornell.xml");
///     const etendue::FilmFile film = etendue::render(scene, {.samples = 64});
///     etendue::write_exr("cornell.exr", etendue::picture_of(film));
///
/// Functions throw etendue::Error, which has a one-sentence message and a kind. Messages and progress are discarded
/// unless a sink is set (log.h); `TerminalLog` is one for programs.

#include "core/errors.h"
#include "core/log.h"
#include "core/parallel.h"
#include "core/terminal.h"
#include "core/version.h"
#include "etendue/compare.h"
#include "etendue/image.h"
#include "etendue/render.h"
#include "etendue/scene.h"
#include "etendue/ttest.h"
