# One place for flags: every library and program of the project calls tendril_target(NAME).
# -Wno-restrict: GCC 12 warns wrongly where a short literal is assigned to a string (its bug 105651).
function(tendril_target name)
  target_compile_options(${name} PRIVATE -Wall -Wextra -Wpedantic -Wshadow -Wnon-virtual-dtor -Wno-restrict -Werror
                                         -ffp-contract=off)
  target_include_directories(${name} PUBLIC ${PROJECT_SOURCE_DIR})
  if(TENDRIL_SANITIZE)
    target_compile_options(${name} PUBLIC -fsanitize=${TENDRIL_SANITIZE} -fno-sanitize-recover=all
                                          -fno-omit-frame-pointer)
    target_link_options(${name} PUBLIC -fsanitize=${TENDRIL_SANITIZE})
  endif()
endfunction()
