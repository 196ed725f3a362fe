// GLFW without OpenGL's header. It declares Vulkan surfaces if Vulkan's header comes first.
#pragma once

#ifdef PELAGE_VIEWER_VULKAN
#include <vulkan/vulkan.h>
#endif

#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>
