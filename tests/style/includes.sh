#!/bin/sh
# Who calls an algorithm of the standard library includes <algorithm>: other compilers' libraries do not bring it along by accident.
set -eu
cd "$1"
calls='std::(ranges::)?(sort|stable_sort|max|min|minmax|max_element|min_element|clamp|all_of|any_of|none_of|count|count_if|find|find_if|transform|fill|copy|copy_n|equal|reverse|remove_if|lower_bound|upper_bound|unique|shuffle|generate|nth_element|partition|is_sorted)\('
users=$(grep -rlE "$calls" src tests examples include python --include='*.cpp' --include='*.h')
[ -n "$users" ] || { echo 'no call found: does this test still look in the right places?'; exit 1; }
status=0
for file in $users; do
  grep -q '^#include <algorithm>' "$file" || { echo "$file calls an algorithm and does not include <algorithm>"; status=1; }
done
exit "$status"
