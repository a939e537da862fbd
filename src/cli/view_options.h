#pragma once
/// The options of `etendue view`, read twice: by the command, whose table help and completion are written from, and by
/// the viewer that it becomes.

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
  unsigned port = 0;  ///< 0: one that is free
  ResultOptions results;

  void add_to(Command& command);
};

}  // namespace etendue::cli
