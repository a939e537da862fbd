#pragma once
/// What the server of a preview answers: the page, what it asks for while it is open, and files to keep.

#include "view/http_server.h"
#include "view/preview.h"

namespace etendue::view {

/// Answers a request for `place` (the path after the token), which was admitted. Below, what the page asks:
///
///     GET  /                    the page; /view.css and /view.js belong to it
///     GET  /next                the state, when it is newer than `version`, or after some seconds as it is; with the
///                               picture unless it is number `picture`; `error=1` wants the standard error, `aov=NAME`
///                               that layer, unless it is number `layer`
///     POST /camera              eye=X,Y,Z target=X,Y,Z up=X,Y,Z fov=DEGREES aperture=RADIUS focus=DISTANCE
///                               moving=0|1 mover=NUMBER
///     POST /reset /reload
///     POST /settings            samples=N paused=0|1 crop=X,Y,W,H maxDepth=N rrDepth=N nee=0|1 mis=0|1
///     GET  /point               x, y: what the pixel shows, as JSON
///     GET  /explain             x, y, sample: what `etendue explain` tells, as JSON, by=device or by=reference
///     GET  /picture.exr         as `render` would write it; /picture.png: by exposure=STOPS tone=NAME
///     GET  /camera.xml          to be pasted; `dialect`: etendue, mitsuba or option
///
/// The answer to /next is a length in four bytes, little-endian, so much JSON, and then what it says: the mean,
/// the standard error, the layer, as `packed` has them.
Response answer(Preview& preview, const std::string& place, const Request& request);

}  // namespace etendue::view
