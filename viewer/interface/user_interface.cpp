#include "interface/user_interface.h"

#include <imgui.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <iterator>
#include <system_error>
#include <utility>

#include "input/event.h"

namespace viewer {

namespace {

constexpr float kFontSize = 14, kBitmapFontSize = 13;    // at scale 1
constexpr float kNameShare = 0.3f, kSliderShare = 0.4f;  // of a window's width
constexpr float kMessageWidth = 440;                     // at scale 1

struct MappedKey {
  ImGuiKey to;
  Key from;
};
constexpr MappedKey kMappedKeys[] = {
    {ImGuiKey_Tab, kKeyTab},
    {ImGuiKey_LeftArrow, kKeyLeft},
    {ImGuiKey_RightArrow, kKeyRight},
    {ImGuiKey_UpArrow, kKeyUp},
    {ImGuiKey_DownArrow, kKeyDown},
    {ImGuiKey_Home, kKeyHome},
    {ImGuiKey_End, kKeyEnd},
    {ImGuiKey_Delete, kKeyDelete},
    {ImGuiKey_Backspace, kKeyBackspace},
    {ImGuiKey_Enter, kKeyEnter},
    {ImGuiKey_Escape, kKeyEscape},
    {ImGuiKey_Space, kKeySpace},
    {ImGuiKey_A, 'A'},
    {ImGuiKey_C, 'C'},
    {ImGuiKey_V, 'V'},
    {ImGuiKey_X, 'X'},
    {ImGuiKey_Y, 'Y'},
    {ImGuiKey_Z, 'Z'},
};

}  // namespace

void text(const std::string& line) { ImGui::TextUnformatted(line.c_str()); }

void textWithValue(const std::string& line, const std::string& value) {
  text(line);
  ImGui::SameLine(ImGui::GetContentRegionMax().x - ImGui::CalcTextSize(value.c_str()).x);
  text(value);
}

void rowName(const char* label) {
  ImGui::AlignTextToFramePadding();
  ImGui::TextUnformatted(label);
  ImGui::SameLine(kNameShare * ImGui::GetContentRegionMax().x);
  ImGui::SetNextItemWidth(-1);
}

bool slider(const char* label, float& value, float low, float high, const char* format,
            bool logarithmic) {
  rowName(label);
  ImGui::SetNextItemWidth(kSliderShare * ImGui::GetContentRegionMax().x);
  ImGui::PushID(label);
  const bool changed = ImGui::SliderFloat("##slider", &value, low, high, "",
                                          logarithmic ? ImGuiSliderFlags_Logarithmic : 0);
  ImGui::PopID();
  if (changed) value = std::clamp(value, low, high);
  ImGui::SameLine();
  ImGui::Text(format, static_cast<double>(value));
  return changed;
}

UserInterface::UserInterface(float scale) {
  ImGui::CreateContext();
  ImGuiIO& io = ImGui::GetIO();
  io.IniFilename = nullptr;
  io.LogFilename = nullptr;
  io.BackendPlatformName = "pelage-viewer";
  for (const MappedKey& key : kMappedKeys) io.KeyMap[key.to] = key.from;
  ImGui::StyleColorsDark();
  ImGuiStyle& style = ImGui::GetStyle();
  style.WindowRounding = 4;
  style.FrameRounding = 2;
  style.Colors[ImGuiCol_WindowBg].w = 0.88f;
  style.ScaleAllSizes(scale);
  std::error_code ignored;
  if (std::filesystem::is_regular_file(PELAGE_VIEWER_FONT, ignored)) {
    io.Fonts->AddFontFromFileTTF(PELAGE_VIEWER_FONT, std::round(kFontSize * scale));
    return;
  }
  ImFontConfig font;
  font.SizePixels = std::round(kBitmapFontSize * scale);
  font.OversampleH = font.OversampleV = 1;
  font.PixelSnapH = true;
  io.Fonts->AddFontDefault(&font);
}

void UserInterface::Press::down(bool& state) {
  state = began = true;
  ends = false;
}
void UserInterface::Press::up(bool& state) {
  if (began)
    ends = true;
  else
    state = false;
}
void UserInterface::Press::built(bool& state) {
  if (ends) state = false;
  began = ends = false;
}

void UserInterface::takeKey(const KeyPressed& event) {
  ImGuiIO& io = ImGui::GetIO();
  if (event.key < 0 || event.key >= static_cast<int>(keys_.size())) return;
  const auto key = static_cast<size_t>(event.key);
  event.down ? keys_[key].down(io.KeysDown[key]) : keys_[key].up(io.KeysDown[key]);
  io.KeyCtrl = io.KeysDown[kKeyLeftControl] || io.KeysDown[kKeyRightControl];
  io.KeyShift = io.KeysDown[kKeyLeftShift] || io.KeysDown[kKeyRightShift];
  io.KeyAlt = io.KeysDown[kKeyLeftAlt] || io.KeysDown[kKeyRightAlt];
}

UserInterface::~UserInterface() { ImGui::DestroyContext(); }

bool UserInterface::take(const Event& event) {
  ImGuiIO& io = ImGui::GetIO();
  if (const auto* moved = std::get_if<MouseMoved>(&event)) {
    io.MousePos = {static_cast<float>(moved->x), static_cast<float>(moved->y)};
    return false;  // drags on the stage need it as well
  }
  if (const auto* button = std::get_if<MousePressed>(&event)) {
    const auto index = static_cast<size_t>(button->button);
    Press& press = buttons_[index];
    button->down ? press.down(io.MouseDown[index]) : press.up(io.MouseDown[index]);
    return button->down && io.WantCaptureMouse;
  }
  if (const auto* scrolled = std::get_if<Scrolled>(&event)) {
    if (!io.WantCaptureMouse) return false;
    io.MouseWheel += static_cast<float>(scrolled->steps);
    return true;
  }
  if (const auto* key = std::get_if<KeyPressed>(&event)) {
    takeKey(*key);
    return io.WantTextInput || hasMessage();
  }
  if (const auto* typed = std::get_if<TextTyped>(&event)) {
    io.AddInputCharacter(typed->character);
    return true;
  }
  return false;
}

void UserInterface::build(const WindowSize& size, double seconds,
                          const std::function<void()>& panels) {
  ImGuiIO& io = ImGui::GetIO();
  io.DisplaySize = {static_cast<float>(size.width), static_cast<float>(size.height)};
  io.DisplayFramebufferScale = {
      static_cast<float>(size.pixelWidth) / static_cast<float>(std::max(size.width, 1u)),
      static_cast<float>(size.pixelHeight) / static_cast<float>(std::max(size.height, 1u))};
  io.DeltaTime = static_cast<float>(std::max(seconds, 1e-4));
  ImGui::NewFrame();
  if (panels) panels();
  buildMessage(size);
  ImGui::Render();
  for (size_t button = 0; button < std::size(buttons_); ++button)
    buttons_[button].built(io.MouseDown[button]);
  for (size_t key = 0; key < keys_.size(); ++key) keys_[key].built(io.KeysDown[key]);
}

ImDrawData* UserInterface::drawData() const { return ImGui::GetDrawData(); }

void UserInterface::say(std::string title, std::string text) {
  const bool said =
      !messages_.empty() && messages_.back().title == title && messages_.back().text == text;
  if (!said) messages_.push_back({std::move(title), std::move(text)});
}

void UserInterface::buildMessage(const WindowSize& size) {
  if (messages_.empty()) return;
  const Message& message = messages_.front();
  const std::string id = message.title + "###message";
  ImGui::OpenPopup(id.c_str());
  const ImVec2 middle = {static_cast<float>(size.width) / 2, static_cast<float>(size.height) / 2};
  const float width =
      std::min(kMessageWidth * size.interfaceScale, 0.9f * static_cast<float>(size.width));
  ImGui::SetNextWindowPos(middle, ImGuiCond_Always, {0.5f, 0.5f});
  ImGui::SetNextWindowSize({width, 0});
  bool closed = false;
  if (ImGui::BeginPopupModal(id.c_str(), nullptr,
                             ImGuiWindowFlags_NoMove | ImGuiWindowFlags_NoResize)) {
    ImGui::TextWrapped("%s", message.text.c_str());
    ImGui::Spacing();
    closed = ImGui::Button("OK", {120 * size.interfaceScale, 0}) ||
             ImGui::IsKeyPressed(kKeyEnter, false) || ImGui::IsKeyPressed(kKeyEscape, false);
    if (closed) ImGui::CloseCurrentPopup();
    ImGui::EndPopup();
  }
  if (closed) messages_.pop_front();
}

}  // namespace viewer
