// {fmt} once: as a header it would take most of the time in which a file that formats compiles.
#include <fmt/format-inl.h>

namespace fmt::detail {

// format.h declares these, and only a library defines them.
template thousands_sep_result<char> thousands_sep_impl(locale_ref);
template char decimal_point_impl(locale_ref);

}  // namespace fmt::detail
