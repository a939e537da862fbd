#pragma once
/// The options of `etendue view`, which are read twice: by the command, whose table yields help and completion, and by
/// the viewer that replaces it.

#include <string>

#include "cli/command.h"
#include "cli/result_files.h"

namespace etendue::cli {

struct ViewOptions {
  std::string scene_file;
  SceneOptions scene;
  SampleOptions sampling;
  DeviceOption device;
  std::string listen = "127.0.0.1";
  unsigned port = 0;  ///< 0: any free port
  ResultOptions results;

  void add_to(Command& command);
};

}  // namespace etendue::cli
