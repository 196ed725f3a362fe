// Messages for invalid ids.
#pragma once

#include "pelage/ids.h"
#include "pelage/result.h"

namespace pelage::detail {

/// \param call  function that refuses the id
/// \param why   result of Slots::whyNot()
Error noSuchThing(const char* call, const char* why);

/// Asserts, and ends the program if the handler returns: there is no object to return.
[[noreturn]] void endForId(const char* call, const char* why);

}  // namespace pelage::detail
