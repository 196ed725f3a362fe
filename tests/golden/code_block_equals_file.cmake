# Fails unless a block of DOCUMENT that is fenced as LANGUAGE (default: cpp) is the whole of SOURCE.
if(NOT LANGUAGE)
  set(LANGUAGE cpp)
endif()
file(READ ${SOURCE} source)
file(READ ${DOCUMENT} document)
string(FIND "${document}" "```${LANGUAGE}\n${source}```" found)
if(found EQUAL -1)
  message(FATAL_ERROR
    "${DOCUMENT}: no ${LANGUAGE} block is ${SOURCE}; copy the file into it")
endif()
