# Run by CPack on the installed files, before it packs them: see cmake/PelagePackage.cmake.
cmake_minimum_required(VERSION 3.25)
set(root ${CPACK_TEMPORARY_INSTALL_DIRECTORY}/usr)
set(doc ${root}/share/doc/${CPACK_PACKAGE_NAME})
if(NOT EXISTS ${doc}/CHANGELOG.md)
  message(FATAL_ERROR "no ${doc}: configure with -DCMAKE_INSTALL_DOCDIR=share/doc/${CPACK_PACKAGE_NAME}")
endif()

function(run)
  execute_process(COMMAND ${ARGN} COMMAND_ERROR_IS_FATAL ANY)
endfunction()

# Static libraries: no debug information, no names of compilers.
file(GLOB_RECURSE libraries ${root}/lib/*.a)
foreach(library IN LISTS libraries)
  run(${CPACK_PELAGE_STRIP} --strip-debug --enable-deterministic-archives --remove-section=.comment
    --remove-section=.note ${library})
endforeach()

# copyright has the text of LICENSE: the holder, an empty line and the terms.
file(READ ${CPACK_PELAGE_SOURCE_DIR}/LICENSE license)
if(NOT license MATCHES "^MIT License\n\nCopyright \\(c\\) ([^\n]+)\n\n(.*)$")
  message(FATAL_ERROR "LICENSE is not the one that packaging/debian/prepare.cmake knows")
endif()
set(holder "${CMAKE_MATCH_1}")
set(terms "${CMAKE_MATCH_2}")
string(REGEX REPLACE "\n+$" "" terms "${terms}")
string(REPLACE "\n\n" "\n.\n" terms "${terms}")
string(REPLACE "\n" "\n " terms "${terms}")

# The tools have parts of these packages linked in: their terms come along.
set(linked glslang-dev spirv-tools libspirv-cross-c-shared-dev libfmt-dev libxxhash-dev nlohmann-json3-dev
  libcli11-dev libeigen3-dev)
foreach(package IN LISTS linked)
  if(NOT EXISTS /usr/share/doc/${package}/copyright)
    message(FATAL_ERROR "no /usr/share/doc/${package}/copyright: what is linked in needs its terms")
  endif()
  configure_file(/usr/share/doc/${package}/copyright ${doc}/linked/${package} COPYONLY)
endforeach()
string(REPLACE ";" ", " linked "${linked}")
file(WRITE ${doc}/copyright "Format: https://www.debian.org/doc/packaging-manuals/copyright-format/1.0/
Upstream-Name: pelage
Comment: The tools and libraries contain code of ${linked};
 their terms are in /usr/share/doc/${CPACK_PACKAGE_NAME}/linked.

Files: *
Copyright: ${holder}
License: Expat
 ${terms}
")
file(REMOVE ${doc}/LICENSE)

# The time of the source if SOURCE_DATE_EPOCH is set, so that the same source makes the same package.
string(TIMESTAMP date "%a, %d %b %Y %H:%M:%S +0000" UTC)
file(WRITE ${doc}/changelog.Debian "${CPACK_PACKAGE_NAME} (${CPACK_PACKAGE_VERSION}-${CPACK_DEBIAN_PACKAGE_RELEASE}) unstable; urgency=medium

  * Package pelage ${CPACK_PACKAGE_VERSION}; its changes are in changelog.gz.

 -- ${CPACK_PACKAGE_CONTACT}  ${date}
")
file(RENAME ${doc}/CHANGELOG.md ${doc}/changelog)
file(GLOB pages ${root}/share/man/man1/*.1)
run(gzip -9n ${doc}/changelog ${doc}/changelog.Debian ${pages})

configure_file(${CPACK_PELAGE_SOURCE_DIR}/packaging/debian/lintian-overrides
  ${root}/share/lintian/overrides/${CPACK_PACKAGE_NAME} COPYONLY)

# Permissions do not depend on the umask of whoever packs.
run(chmod -R u=rwX,go=rX ${CPACK_TEMPORARY_INSTALL_DIRECTORY})
