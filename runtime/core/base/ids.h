// What is said of ids that name nothing.
#pragma once

#include "pelage/ids.h"
#include "pelage/result.h"

namespace pelage::detail {

/// \param call  which refuses the id
/// \param why   of Slots::whyNot()
Error noSuchThing(const char* call, const char* why);

/// Asserts, and ends the program where the handler returns: there is no object to return.
[[noreturn]] void endForId(const char* call, const char* why);

}  // namespace pelage::detail
