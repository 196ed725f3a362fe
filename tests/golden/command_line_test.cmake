# Runs pelage-headless with arguments that must fail before any device is needed: the exit code is
# not 0, and stderr is one line that says what was wrong.
file(REMOVE_RECURSE ${WORK_DIR})
file(MAKE_DIRECTORY ${WORK_DIR})
file(WRITE ${WORK_DIR}/truncated.tfx "short")
set(failures 0)

function(must_fail expected)
  execute_process(COMMAND ${PROGRAM} ${ARGN} WORKING_DIRECTORY ${WORK_DIR}
    RESULT_VARIABLE code OUTPUT_VARIABLE output ERROR_VARIABLE errors TIMEOUT 60)
  if(NOT code MATCHES "^[12]$" OR
     NOT errors MATCHES "^pelage-headless: error: [^\n]*${expected}[^\n]*\n$")
    message(SEND_ERROR "pelage-headless ${ARGN}\nexit code ${code}, stderr:\n${errors}")
  endif()
endfunction()

must_fail("--frames" --frames many)
must_fail("--frames" --frames 0)
must_fail("--samples" --samples 3)
must_fail("--api: .metal. is none of: gl, gles, vulkan" --api metal)
must_fail("matrices" --skinning bones)
must_fail("--wind" --wind 1,2)
must_fail("--wind" --wind nan,0,0)
must_fail("--no-such-option" --no-such-option)
must_fail("--asset" --bones groom.tfxbone)
must_fail("--supersample" --width 16384 --supersample 2)
must_fail("--scene: .tail. is none of: character, head" --scene tail)
must_fail("--motion: .fly. is none of" --motion fly)
must_fail("--motion" --scene head --motion walk)
must_fail("--groom" --scene character --groom fur)
must_fail("--repeat" --repeat 2)
must_fail("--scene" --asset missing.tfx --scene head)
must_fail("missing.tfx" --asset missing.tfx)
must_fail("truncated.tfx" --asset truncated.tfx)
