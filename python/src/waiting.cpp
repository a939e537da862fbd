#include <chrono>
#include <condition_variable>
#include <exception>
#include <mutex>
#include <thread>

#include "module.h"

namespace etendue::python {
namespace {

/// Keeps what the library says until a thread with the GIL takes it: the library may speak from any thread, and
/// logging needs the GIL.
class MessageQueue : public log::Sink {
 public:
  static constexpr std::size_t kMost = 1000;

  void message(log::Level level, std::string_view sentence) noexcept override {
    try {
      const std::lock_guard lock(mutex_);
      if (messages_.size() < kMost) messages_.emplace_back(level, sentence);
    } catch (const std::exception&) {  // no memory left for a message: the work matters more
    }
  }
  void progress(std::string_view, double) noexcept override {}
  void progress_ended(std::string_view) noexcept override {}

  std::vector<std::pair<log::Level, std::string>> take() {
    const std::lock_guard lock(mutex_);
    return std::exchange(messages_, {});
  }

 private:
  std::mutex mutex_;
  std::vector<std::pair<log::Level, std::string>> messages_;
};

/// Lives for ever: threads of the library may outlive the module's static objects.
MessageQueue& messages() {
  static MessageQueue* const queue = [] {
    auto* made = new MessageQueue;
    log::set_sink(made);
    return made;
  }();
  return *queue;
}

/// A thread whose end can be waited for with a time limit.
class Worker {
 public:
  explicit Worker(const std::function<void()>& work) : thread_([this, work] { run(work); }) {}
  ~Worker() { thread_.join(); }
  Worker(const Worker&) = delete;
  Worker& operator=(const Worker&) = delete;

  bool wait_for(std::chrono::milliseconds time) {
    std::unique_lock lock(mutex_);
    return ended_.wait_for(lock, time, [this] { return over_; });
  }
  /// After the end.
  std::exception_ptr failure() const { return failure_; }

 private:
  void run(const std::function<void()>& work) {
    try {
      work();
    } catch (...) {
      failure_ = std::current_exception();
    }
    const std::lock_guard lock(mutex_);
    over_ = true;
    ended_.notify_one();
  }

  std::mutex mutex_;
  std::condition_variable ended_;
  bool over_ = false;
  std::exception_ptr failure_;
  std::thread thread_;
};

/// What is raised now, taken from the interpreter.
nb::object take_raised() {
  const nb::python_error raised;
  return nb::borrow(raised.value());
}

}  // namespace

void deliver_messages() {
  const auto taken = messages().take();
  if (taken.empty()) return;
  try {
    const nb::object logger = nb::module_::import_("logging").attr("getLogger")("etendue");
    for (const auto& [level, sentence] : taken) {
      const char* method = level == log::Level::error     ? "error"
                           : level == log::Level::warning ? "warning"
                           : level == log::Level::info    ? "info"
                                                          : "debug";
      logger.attr(method)("%s", sentence);
    }
  } catch (nb::python_error& error) {
    error.discard_as_unraisable("messages of etendue");
  }
}

nb::object run_interruptibly(const std::function<void()>& work, Control& control, const nb::object& progress) {
  constexpr std::chrono::milliseconds kBetweenLooks{50};
  messages();
  nb::object raised = nb::none();
  std::exception_ptr failure;
  {
    Worker worker(work);
    std::uint64_t told = 0;
    for (bool over = false; !over;) {
      {
        const nb::gil_scoped_release waiting;
        over = worker.wait_for(kBetweenLooks);
      }
      if (PyErr_CheckSignals() != 0) {
        control.stop = true;
        raised = take_raised();
      }
      deliver_messages();
      const std::uint64_t done = control.done;
      if (progress.is_none() || control.total == 0 || done == told || !raised.is_none()) continue;
      told = done;
      try {
        progress(done, control.total);
      } catch (nb::python_error& error) {
        control.stop = true;
        raised = nb::borrow(error.value());
      }
    }
    failure = worker.failure();
  }
  if (failure && raised.is_none()) std::rethrow_exception(failure);
  return raised;
}

void run_waiting(const std::function<void()>& work) {
  Control control;
  const nb::object raised = run_interruptibly(work, control, nb::none());
  if (raised.is_none()) return;
  PyErr_SetObject(reinterpret_cast<PyObject*>(Py_TYPE(raised.ptr())), raised.ptr());
  throw nb::python_error();
}

}  // namespace etendue::python
