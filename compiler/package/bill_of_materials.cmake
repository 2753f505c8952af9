# What the packages hold and are built with, as SPDX 2.3 (https://spdx.github.io/spdx-spec/v2.3). The same sources and
# libraries give the same bytes.

# That of the newest entry of the changelog: it must not change from build to build.
file(STRINGS ${PROJECT_SOURCE_DIR}/compiler/package/changelog entry REGEX "^ -- " LIMIT_COUNT 1)
if(NOT entry MATCHES ", ([0-9][0-9]) ([A-Z][a-z][a-z]) ([0-9]+) ([0-9:]+) [+]0000$")
  message(FATAL_ERROR "compiler/package/changelog: an entry ends in a date in UTC, as RFC 5322 has it")
endif()
set(months Jan Feb Mar Apr May Jun Jul Aug Sep Oct Nov Dec)
list(FIND months ${CMAKE_MATCH_2} month)
math(EXPR month "${month} + 101")
string(SUBSTRING ${month} 1 2 month)
set(created "${CMAKE_MATCH_3}-${month}-${CMAKE_MATCH_1}T${CMAKE_MATCH_4}Z")

set(packages "")
set(relationships "")
foreach(library ${libraries})
  string(REPLACE "|" ";" library ${library})
  list(GET library 0 name)
  list(GET library 1 licence)
  list(GET library 2 version)
  string(APPEND packages ",
    {\"SPDXID\": \"SPDXRef-${name}\", \"name\": \"${name}\", \"versionInfo\": \"${version}\",
     \"downloadLocation\": \"NOASSERTION\", \"filesAnalyzed\": false,
     \"licenseConcluded\": \"NOASSERTION\", \"licenseDeclared\": \"${licence}\", \"copyrightText\": \"NOASSERTION\"}")
  string(APPEND relationships ",
    {\"spdxElementId\": \"SPDXRef-sightline\", \"relationshipType\": \"DEPENDS_ON\",
     \"relatedSpdxElement\": \"SPDXRef-${name}\"}")
endforeach()
string(SHA256 digest "${PROJECT_VERSION} ${packages}")
file(WRITE ${PROJECT_BINARY_DIR}/sightline.spdx.json "{
  \"spdxVersion\": \"SPDX-2.3\",
  \"dataLicense\": \"CC0-1.0\",
  \"SPDXID\": \"SPDXRef-DOCUMENT\",
  \"name\": \"sightline-${PROJECT_VERSION}\",
  \"documentNamespace\": \"https://spdx.org/spdxdocs/sightline-${PROJECT_VERSION}-${digest}\",
  \"creationInfo\": {\"created\": \"${created}\", \"creators\": [\"Tool: cmake-${CMAKE_VERSION}\"]},
  \"packages\": [
    {\"SPDXID\": \"SPDXRef-sightline\", \"name\": \"sightline\", \"versionInfo\": \"${PROJECT_VERSION}\",
     \"downloadLocation\": \"NOASSERTION\", \"filesAnalyzed\": false,
     \"licenseConcluded\": \"Apache-2.0\", \"licenseDeclared\": \"Apache-2.0\", \"copyrightText\": \"NOASSERTION\"}${packages}
  ],
  \"relationships\": [
    {\"spdxElementId\": \"SPDXRef-DOCUMENT\", \"relationshipType\": \"DESCRIBES\",
     \"relatedSpdxElement\": \"SPDXRef-sightline\"}${relationships}
  ]
}
")
