// A display without a screen, for windows of tests: an Xvfb with a minimal window manager.
#pragma once

#include <sys/types.h>

#include <atomic>
#include <string>
#include <thread>

struct _XDisplay;  // Display of Xlib

namespace pelage::test {

class XDisplay {
 public:
  /// Starts an Xvfb. \param dotsPerInch of its settings; 96 is usual.
  explicit XDisplay(int dotsPerInch = 96);
  ~XDisplay();
  XDisplay(const XDisplay&) = delete;
  XDisplay& operator=(const XDisplay&) = delete;
  /// Returns its name, such as ":7"; empty: Xvfb did not start.
  const std::string& name() const { return name_; }

 private:
  void manageWindows() const;
  pid_t process_ = -1;
  _XDisplay* server_ = nullptr;
  std::string name_;
  std::atomic<bool> ends_ = false;
  std::thread manager_;
};

}  // namespace pelage::test
