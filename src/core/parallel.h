#pragma once
/// A fixed set of worker threads and one way to use it.

#include <cstdint>
#include <functional>

namespace etendue {

/// Number of threads that `parallel_for` uses: those of the hardware (within the CPU affinity mask), unless set.
unsigned thread_count();
void set_thread_count(unsigned count);

/// Calls `body(begin, end)` for disjoint chunks of at most `grain` indices that cover [0, count), from several threads;
/// returns when all are done. The first exception thrown by a body is rethrown here after all threads have stopped.
void parallel_for(std::uint64_t count, std::uint64_t grain,
                  const std::function<void(std::uint64_t begin, std::uint64_t end)>& body);

}  // namespace etendue
