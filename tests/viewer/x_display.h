// A display without a screen, for windows of tests: an Xvfb with the least of a window manager.
#pragma once

#include <sys/types.h>

#include <atomic>
#include <string>
#include <thread>

struct _XDisplay;  // Display of Xlib

namespace pelage::test {

class XDisplay {
 public:
  /// Starts it. \param dotsPerInch that its settings name; 96 is the usual.
  explicit XDisplay(int dotsPerInch = 96);
  ~XDisplay();
  XDisplay(const XDisplay&) = delete;
  XDisplay& operator=(const XDisplay&) = delete;
  /// ":7"; empty: Xvfb does not start.
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
