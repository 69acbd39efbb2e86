"""The verdicts as JUnit XML, for the build servers that read it."""

from __future__ import annotations

from pathlib import Path

from junitparser import Error, Failure, JUnitXml, Skipped, TestCase, TestSuite

from validation.record import BROKEN, FAILS, NOT_RUN, Report, write_whole


def write_junit(report: Report, path: Path) -> None:
    """Write a test suite a family and a test case a claim."""
    xml = JUnitXml("softbody validation")
    for family in dict.fromkeys(claim.family for claim in report.claims):
        suite = TestSuite(family)
        for claim in report.claims:
            if claim.family != family:
                continue
            case = TestCase(claim.id, classname=f"validation.{claim.family}", time=claim.seconds)
            if claim.verdict == FAILS:
                kind = Failure if claim.value is not None else Error
                case.result = [kind(f"{claim.claim}: {claim.why}")]
            elif claim.verdict == BROKEN:
                case.result = [Error(f"engine broken: {claim.why}")]
            elif claim.verdict == NOT_RUN:
                case.result = [Skipped(claim.why or "")]
            suite.add_testcase(case)
        xml.add_testsuite(suite)
    xml.update_statistics()
    write_whole(path, xml.tostring().decode("utf-8"))
