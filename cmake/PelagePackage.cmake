# The Debian package libpelage-dev, made by scripts/package.sh: one package with all that is installed, since
# static libraries are of use to developers only. What Debian asks of the files of a package is done by
# packaging/debian/prepare.cmake before they are packed.
file(READ ${PROJECT_SOURCE_DIR}/README.md pelage_readme)
if(NOT pelage_readme MATCHES "\n(Hair and fur kernels([^\n]+\n)+)")
  message(FATAL_ERROR "README.md has no paragraph 'Hair and fur kernels ...' to describe the package with")
endif()
# In lines that a terminal has room for.
string(REGEX REPLACE "[ \n]+" ";" words "${CMAKE_MATCH_1}")
set(text)
set(line)
foreach(word IN LISTS words)
  string(LENGTH "${line} ${word}" length)
  if(length GREATER 74)
    string(APPEND text "${line}\n")
    set(line ${word})
  else()
    string(STRIP "${line} ${word}" line)
  endif()
endforeach()
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "${PROJECT_DESCRIPTION}")
set(CPACK_DEBIAN_PACKAGE_DESCRIPTION "${text}${line}
.
This package has the static libraries, headers, HLSL sources, CMake and
pkg-config files, documentation, and the tools pelage-codegen and
pelage-convert.")

set(PELAGE_PACKAGE_MAINTAINER "The pelage developers <pelage@pelage.invalid>" CACHE STRING
  "Maintainer of the Debian package: name <address>")
mark_as_advanced(PELAGE_PACKAGE_MAINTAINER)

# What the CMake package looks for; the tools need what they are linked with.
set(pelage_package_depends libzstd-dev)
if(PELAGE_VULKAN)
  list(APPEND pelage_package_depends libvulkan-dev)
endif()
if(PELAGE_GL)
  list(APPEND pelage_package_depends libegl-dev libopengl-dev libgl-dev)
endif()
if(PELAGE_MESH_IMPORT)
  list(APPEND pelage_package_depends libassimp-dev)
endif()
if(PELAGE_AUTHORING)
  list(APPEND pelage_package_depends libmeshoptimizer-dev)
endif()
string(REPLACE ";" ", " CPACK_DEBIAN_PACKAGE_DEPENDS "${pelage_package_depends}")

set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_NAME libpelage-dev)
set(CPACK_PACKAGE_CONTACT "${PELAGE_PACKAGE_MAINTAINER}")
set(CPACK_PACKAGE_VERSION ${PROJECT_VERSION})
set(CPACK_DEBIAN_PACKAGE_RELEASE 1)
set(CPACK_DEBIAN_PACKAGE_SECTION libdevel)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_COMPRESSION_TYPE xz)
set(CPACK_STRIP_FILES ON)
set(CPACK_PRE_BUILD_SCRIPTS ${PROJECT_SOURCE_DIR}/packaging/debian/prepare.cmake)
# For the script.
set(CPACK_PELAGE_SOURCE_DIR ${PROJECT_SOURCE_DIR})
set(CPACK_PELAGE_STRIP ${CMAKE_STRIP})
include(CPack)
