# One place for flags: every library and program of the project calls tendril_target(NAME).
function(tendril_target name)
  target_compile_options(${name} PRIVATE -Wall -Wextra -Wpedantic -Wshadow -Wnon-virtual-dtor -Werror
                                         -ffp-contract=off)
  target_include_directories(${name} PUBLIC ${PROJECT_SOURCE_DIR})
  if(TENDRIL_SANITIZE)
    target_compile_options(${name} PUBLIC -fsanitize=${TENDRIL_SANITIZE} -fno-sanitize-recover=all
                                          -fno-omit-frame-pointer -O1)
    target_link_options(${name} PUBLIC -fsanitize=${TENDRIL_SANITIZE})
  endif()
endfunction()
