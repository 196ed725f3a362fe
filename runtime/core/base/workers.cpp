#include "base/workers.h"

#include <atomic>
#include <condition_variable>
#include <exception>
#include <mutex>
#include <system_error>
#include <thread>
#include <vector>

namespace pelage::detail {

struct Workers::Impl {
  std::mutex mutex;
  std::condition_variable begins, ends;
  const std::function<void(size_t, uint32_t)>* code = nullptr;
  size_t items = 0;
  std::atomic<size_t> next = 0;
  uint64_t loops = 0;  ///< that have begun
  size_t busy = 0;     ///< threads that have not ended the last one
  bool stops = false;
  std::exception_ptr thrown;
  std::vector<std::thread> threads;

  ~Impl();
  void work(uint32_t worker);
  void wait(uint32_t worker);
};

Workers::Impl::~Impl() {
  {
    const std::lock_guard lock(mutex);
    stops = true;
  }
  begins.notify_all();
  for (std::thread& thread : threads) thread.join();
}

// Takes items until there are none.
void Workers::Impl::work(uint32_t worker) {
  try {
    for (size_t item = next++; item < items; item = next++) (*code)(item, worker);
  } catch (...) {
    const std::lock_guard lock(mutex);
    thrown = std::current_exception();
    next = items;
  }
}

void Workers::Impl::wait(uint32_t worker) {
  uint64_t seen = 0;
  std::unique_lock lock(mutex);
  for (;;) {
    begins.wait(lock, [&] { return stops || loops != seen; });
    if (stops) return;
    seen = loops;
    lock.unlock();
    work(worker);
    lock.lock();
    if (--busy == 0) ends.notify_one();
  }
}

Workers::Workers(uint32_t threads) : impl_(std::make_unique<Impl>()) {
  try {
    for (uint32_t worker = 1; worker < threads; ++worker)
      impl_->threads.emplace_back([impl = impl_.get(), worker] { impl->wait(worker); });
  } catch (const std::system_error&) {  // with those that there are
  }
}

Workers::~Workers() = default;

uint32_t Workers::count() const { return static_cast<uint32_t>(impl_->threads.size()) + 1; }

void Workers::run(size_t items, const std::function<void(size_t, uint32_t)>& code) {
  Impl& impl = *impl_;
  {
    const std::lock_guard lock(impl.mutex);
    impl.code = &code;
    impl.items = items;
    impl.next = 0;
    impl.thrown = nullptr;
    impl.busy = impl.threads.size();
    ++impl.loops;
  }
  impl.begins.notify_all();
  impl.work(0);
  std::unique_lock lock(impl.mutex);
  impl.ends.wait(lock, [&] { return impl.busy == 0; });
  if (impl.thrown) std::rethrow_exception(impl.thrown);
}

}  // namespace pelage::detail
