# Fails unless the first ```cpp block of DOCUMENT is the whole of SOURCE.
file(READ ${SOURCE} source)
file(READ ${DOCUMENT} document)
string(FIND "${document}" "```cpp\n${source}```" found)
if(found EQUAL -1)
  message(FATAL_ERROR "${DOCUMENT}: the cpp block is not ${SOURCE}; copy the file into it")
endif()
