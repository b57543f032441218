# board_field(<variable> <field>): of the board that DAVAR_TARGET names, from boards.json, the one place that lists them.
file(READ "${CMAKE_CURRENT_LIST_DIR}/../boards.json" boards)
function(board_field variable field)
  string(JSON value ERROR_VARIABLE missing GET "${boards}" "${DAVAR_TARGET}" "${field}")
  if(missing)
    message(FATAL_ERROR "DAVAR_TARGET: a board of port/bare_metal/boards.json with a ${field}, found '${DAVAR_TARGET}'")
  endif()
  set(${variable} "${value}" PARENT_SCOPE)
endfunction()
