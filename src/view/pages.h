#pragma once
/// The responses of a preview's server: the page, the data that it requests while it is open, and files to save.

#include "view/http_server.h"
#include "view/preview.h"

namespace etendue::view {

/// Answers an admitted request for `place`, the path after the token:
///
///     GET  /                    the page; /view.css and /view.js belong to it
///     GET  /next                the state, once it is newer than `version`, or after some seconds as it is; with the
///                               picture unless it is number `picture`; `error=1` wants the standard error, `aov=NAME`
///                               that layer, unless it is number `layer`
///     POST /camera              eye=X,Y,Z target=X,Y,Z up=X,Y,Z fov=DEGREES aperture=RADIUS focus=DISTANCE
///                               moving=0|1 mover=NUMBER
///     POST /reset /reload
///     POST /settings            samples=N paused=0|1 crop=X,Y,W,H maxDepth=N rrDepth=N nee=0|1 mis=0|1
///     GET  /point               x, y: what the pixel shows, as JSON
///     GET  /explain             x, y, sample: what `etendue explain` tells, as JSON, by=device or by=reference
///     GET  /picture.exr         as `render` would write it; /picture.png: by exposure=STOPS tone=NAME
///     GET  /camera.xml          text for a scene file; `dialect`: etendue, mitsuba or option
///
/// The response to /next is the length of the JSON in four bytes, little-endian, then the JSON, then what it announces:
/// the mean, the standard error and the layer, as returned by `packed`.
Response answer(Preview& preview, const std::string& place, const Request& request);

}  // namespace etendue::view
