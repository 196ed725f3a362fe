# Every trap of codegen/checks, one file each.
pelage_add_test(codegen_checks_test
  SOURCES checks_test.cpp
  LIBRARIES pelage_codegen
  LABELS unit)
