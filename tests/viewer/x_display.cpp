#include "viewer/x_display.h"

#include <X11/Xatom.h>
#include <X11/Xlib.h>
#include <X11/Xutil.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <chrono>

namespace pelage::test {

namespace {

// Tells the program of a window its state, as ICCCM 4.1.3.1 wants.
void setState(::Display* server, Atom property, ::Window window, long state) {
  const long words[2] = {state, None};
  XChangeProperty(server, window, property, property, 32, PropModeReplace,
                  reinterpret_cast<const unsigned char*>(words), 2);
}

}  // namespace

XDisplay::XDisplay(int dotsPerInch) {
  std::array<int, 2> ends = {-1, -1};
  if (pipe(ends.data()) != 0) return;
  process_ = fork();
  if (process_ == 0) {
    const std::string number = std::to_string(ends[1]);
    close(ends[0]);
    execlp("Xvfb", "Xvfb", "-displayfd", number.c_str(), "-screen", "0", "1280x1024x24",
           "-nolisten", "tcp", "-noreset", static_cast<char*>(nullptr));
    _exit(127);
  }
  close(ends[1]);
  char digit = 0;
  std::string number;
  while (read(ends[0], &digit, 1) == 1 && digit != '\n') number += digit;
  close(ends[0]);
  if (number.empty()) return;
  name_ = ":" + number;
  server_ = XOpenDisplay(name_.c_str());
  if (server_ == nullptr) return;
  // Programs read the dots per inch here, where xrdb writes them.
  const std::string resources = "Xft.dpi:\t" + std::to_string(dotsPerInch) + "\n";
  XChangeProperty(server_, DefaultRootWindow(server_), XA_RESOURCE_MANAGER, XA_STRING, 8,
                  PropModeReplace, reinterpret_cast<const unsigned char*>(resources.data()),
                  static_cast<int>(resources.size()));
  XSync(server_, False);
  manager_ = std::thread([this] { manageWindows(); });
}

XDisplay::~XDisplay() {
  ends_ = true;
  if (manager_.joinable()) manager_.join();
  if (server_ != nullptr) XCloseDisplay(server_);
  if (process_ <= 0) return;
  kill(process_, SIGTERM);
  waitpid(process_, nullptr, 0);
}

// Minimizes windows that ask for it, and tells programs when their windows are mapped.
void XDisplay::manageWindows() const {
  ::Display* const server = server_;
  // Windows may be destroyed before their events are handled.
  XSetErrorHandler([](::Display*, XErrorEvent*) { return 0; });
  const Atom state = XInternAtom(server, "WM_STATE", False);
  const Atom change = XInternAtom(server, "WM_CHANGE_STATE", False);
  XSelectInput(server, DefaultRootWindow(server), SubstructureNotifyMask);
  while (!ends_) {
    if (XPending(server) == 0) {
      std::this_thread::sleep_for(std::chrono::milliseconds(2));
      continue;
    }
    XEvent event;
    XNextEvent(server, &event);
    if (event.type == MapNotify) setState(server, state, event.xmap.window, NormalState);
    if (event.type != ClientMessage || event.xclient.message_type != change) continue;
    setState(server, state, event.xclient.window, IconicState);
    XUnmapWindow(server, event.xclient.window);
  }
}

}  // namespace pelage::test
