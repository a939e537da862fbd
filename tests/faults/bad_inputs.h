#pragma once
/// Runs the program on bad inputs, one after the other, each in a folder of its own and under limits of memory and
/// time.

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "process.h"

namespace etendue::faults {

/// A run that must be refused.
struct BadInput {
  std::string name;                ///< for messages
  std::vector<std::string> files;  ///< name, content, name, content, …
  std::vector<std::string> arguments;
  int code = 3;
  std::string place;                                          ///< regular expression for the start of the sentence
  std::string words;                                          ///< what the sentence must hold; plain text
  std::function<void(const std::filesystem::path&)> prepare;  ///< makes what is no plain file
};

/// Runs the program and expects: the exit code, one error sentence on stderr that begins with the place and holds the
/// words, within the limits, and a folder that looks as before, temporary files included.
void expect_refused(const BadInput& input);

/// A scene around `content`, which stands in the lines from 2 on; and a scene that shows mesh.obj.
std::string scene_with(const std::string& content);
std::string scene_of_mesh();
/// The arguments that render scene.xml.
std::vector<std::string> render_scene();

}  // namespace etendue::faults
