#include "core/log.h"

#include <atomic>
#include <mutex>

namespace etendue::log {
namespace {

std::atomic<Level> g_level{Level::info};
std::mutex g_mutex;  // of the sink and of its calls
Sink* g_sink = nullptr;

template <typename Call>
void tell(Level level, Call call) noexcept {
  if (level > g_level) return;
  const std::lock_guard lock(g_mutex);
  if (g_sink != nullptr) call(*g_sink);
}

void message(Level level, std::string_view sentence) noexcept {
  tell(level, [&](Sink& sink) { sink.message(level, sentence); });
}

}  // namespace

void set_sink(Sink* sink) noexcept {
  const std::lock_guard lock(g_mutex);
  g_sink = sink;
}

void set_level(Level level) noexcept {
  g_level = level;
}
Level level() noexcept {
  return g_level;
}

void error(std::string_view sentence) noexcept {
  message(Level::error, sentence);
}
void warning(std::string_view sentence) noexcept {
  message(Level::warning, sentence);
}
void info(std::string_view sentence) noexcept {
  message(Level::info, sentence);
}
void debug(std::string_view sentence) noexcept {
  message(Level::debug, sentence);
}
void progress(std::string_view what, double fraction) noexcept {
  tell(Level::info, [&](Sink& sink) { sink.progress(what, fraction); });
}
void progress_ended(std::string_view what) noexcept {
  tell(Level::info, [&](Sink& sink) { sink.progress_ended(what); });
}

}  // namespace etendue::log
