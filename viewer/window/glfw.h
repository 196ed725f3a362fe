// GLFW, without OpenGL's header; with surfaces of Vulkan, which it declares behind Vulkan's.
#pragma once

#ifdef PELAGE_VIEWER_VULKAN
#include <vulkan/vulkan.h>
#endif

#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>
