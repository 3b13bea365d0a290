//! The page and its JSON: structure, escaping, odd data, size.

use std::time::Instant;

use numerics::random::SplitMix64;
use proptest::prelude::*;
use report::{
    Axis, Bode, Column, Figure, Histogram, KeyFigure, Provenance, Report, ReportError, Role,
    Section, Spectrum, Table, TimeSeries, Value, Verdict, XyLoop,
};

fn report(section: Section) -> Report {
    Report::new("identify", "A title", Verdict::pass("The sentence."))
        .warning("A warning.")
        .key_figure(KeyFigure::new("RMSE", 0.61, "um").at_most(0.8).note("held out"))
        .section(section)
        .provenance(Provenance::new("piezoloop", "0.1.0").command_line(["piezoloop"]).seed(7))
}

/// One figure of each kind over the same values.
fn every_figure(name: &str, unit: &str, values: &[f64]) -> Vec<Figure> {
    let time: Vec<f64> = (0..values.len()).map(|i| i as f64 * 1e-3).collect();
    let axis = || Axis::new(name, unit);
    vec![
        TimeSeries::new(name, &time)
            .panel(name)
            .measured(name, unit, values)
            .model(name, unit, values)
            .other(name, name, values)
            .limit(0.5, name)
            .band(0.0, 0.1, name)
            .marker(0.05, name)
            .caption(name)
            .into(),
        TimeSeries::over(name, axis(), values).residual(name, unit, values).into(),
        XyLoop::new(name, axis(), axis())
            .measured(name, values, &time)
            .model(name, &time, values)
            .equal_scale()
            .into(),
        Spectrum::new(name, axis())
            .trace(Role::Residual, name, &time, values)
            .limit(1.0, name)
            .band(0.01, 0.1, name)
            .marker(0.05, name)
            .into(),
        Spectrum::new(name, axis()).linear().trace(Role::Other, name, values, &time).into(),
        Bode::new(name, unit)
            .response(Role::Measured, name, &time, values, values, Some(values))
            .response(Role::Model, name, values, &time, &time, None)
            .marker(0.05, name)
            .into(),
        Histogram::new(name, axis(), &[(Role::Residual, name, values), (Role::Other, name, &time)])
            .marker(0.05, name)
            .into(),
    ]
}

fn with_figures(figures: Vec<Figure>) -> Report {
    report(figures.into_iter().fold(Section::new("Figures"), Section::figure))
}

/// Where `needle` stands in the page, after `from`.
fn find(page: &str, needle: &str, from: usize) -> usize {
    page[from..].find(needle).unwrap_or_else(|| panic!("`{needle}` is missing")) + from
}

#[test]
fn the_sentence_comes_first_and_the_provenance_last() {
    let table = Table::new("Parameters", [Column::new("w").unit("um").decimals(2), "name".into()])
        .row([Value::from(1.0), "a".into()])
        .row([f64::NAN]);
    let section = Section::new("Evidence")
        .paragraph("Text.")
        .list(["item"])
        .code("piezoloop pack")
        .table(table)
        .figure(TimeSeries::new("Overlay", &[0.0, 1.0]).measured("y", "um", &[1.0, 2.0]));
    let page = report(section).to_html().unwrap();
    let order = [
        "<!DOCTYPE html>\n<html lang=\"en\">",
        "Content-Security-Policy",
        "<title>A title</title>",
        "<style>",
        "<header>",
        "<h1>A title</h1>",
        "<p class=\"badge\">Pass</p>",
        "The sentence.",
        "A warning.",
        "<main id=\"content\">",
        "<dt>RMSE</dt>",
        ">0.61</span> <span class=\"unit\">µm</span>",
        "at most 0.8 µm",
        "held out",
        "<h2 id=\"section-1\">Evidence</h2>",
        "<p>Text.</p>",
        "<li>item</li>",
        "<pre tabindex=\"0\"><code>piezoloop pack</code></pre>",
        "Table 1</span> Parameters",
        "w <span class=\"unit\">[µm]</span>",
        "<td class=\"numeric\">1.00</td>",
        "<td>a</td>",
        "<td class=\"numeric\">–</td>",
        "<td>–</td>",
        "Figure 1</span> Overlay",
        "<ul class=\"legend\">",
        "<svg",
        "<title id=\"figure-1-wide-title\">Overlay</title>",
        "<desc id=\"figure-1-wide-desc\">Signals over time from 0 to 1 s: y.</desc>",
        "Data of figure 1",
        "<script type=\"application/json\" data-chart=\"figure-1\">",
        "<h2 id=\"provenance\">Provenance</h2>",
        "<dt>Seed</dt><dd>7</dd>",
        "</main>",
        "</html>",
    ];
    let mut at = 0;
    for needle in order {
        at = find(&page, needle, at);
    }
}

#[test]
fn the_page_can_load_nothing() {
    let values: Vec<f64> = (0..100).map(f64::from).collect();
    let page = with_figures(every_figure("y", "um", &values)).to_html().unwrap();
    let policy = &page[find(&page, "content=\"default-src", 0)..];
    let policy = &policy[..policy.find('>').unwrap()];
    assert!(policy.contains("default-src &#x27;none&#x27;"), "{policy}");
    assert!(!policy.contains("unsafe"), "{policy}");
    assert_eq!(policy.matches("sha256-").count(), 3, "two scripts, one style sheet: {policy}");
    for loading in ["src=\"", "<link rel=\"stylesheet", "@import", "url(", " style=\"", " onclick"]
    {
        assert!(!page.contains(loading), "{loading}");
    }
}

#[test]
fn a_page_without_figures_has_no_scripts() {
    let page = report(Section::new("Empty")).to_html().unwrap();
    assert!(!page.contains("<script"));
    assert!(page.contains("script-src &#x27;none&#x27;"));
}

#[test]
fn identifiers_are_unique() {
    let values: Vec<f64> = (0..100).map(f64::from).collect();
    let page = with_figures(every_figure("y", "um", &values)).to_html().unwrap();
    let mut identifiers: Vec<&str> =
        page.split(" id=\"").skip(1).filter_map(|rest| rest.split('"').next()).collect();
    let count = identifiers.len();
    identifiers.sort_unstable();
    identifiers.dedup();
    assert!(count > 20 && identifiers.len() == count);
}

#[test]
fn hostile_names_stay_text() {
    let hostile = "</script><script>alert(1)</script><img src=x onerror=alert(1)>\"'&{{ 7*7 }}\u{0}\u{2028}]]>";
    let values = [1.0, 2.0, 3.0];
    let mut hostile_report = Report::new(hostile, hostile, Verdict::fail(hostile))
        .warning(hostile)
        .key_figure(KeyFigure::new(hostile, hostile, hostile).note(hostile))
        .provenance(
            Provenance::new(hostile, hostile)
                .command_line([hostile])
                .remark(hostile, hostile)
                .time(hostile),
        );
    let mut section = Section::new(hostile)
        .paragraph(hostile)
        .code(hostile)
        .list([hostile])
        .table(Table::new(hostile, [Column::new(hostile).unit(hostile)]).row([hostile]));
    for figure in every_figure(hostile, hostile, &values) {
        let svg = figure.to_svg();
        assert!(!svg.contains("<script") && !svg.contains("<img"), "{svg}");
        section = section.figure(figure);
    }
    hostile_report = hostile_report.section(section);
    let page = hostile_report.to_html().unwrap();
    assert!(
        !page.contains("alert(1)</script>") && !page.contains("<img") && !page.contains(">49<")
    );
    // Every script element is one of ours: data, uPlot, the interactive layer.
    let ours = page.matches("<script type=\"application/json\" data-chart=\"figure-").count() + 2;
    assert_eq!(page.matches("<script").count(), ours);
    assert_eq!(page.matches("</script").count(), ours);
    assert_eq!(Report::from_json(&hostile_report.to_json().unwrap()).unwrap(), hostile_report);
}

#[test]
fn odd_data_is_noted_on_the_page() {
    let message = |figure: Figure, words: &str| {
        let page = with_figures(vec![figure]).to_html().unwrap();
        assert!(page.contains(words), "`{words}` is not on the page");
    };
    let time = [0.0, 1.0, 2.0];
    let series = |values: &[f64]| TimeSeries::new("t", &time).measured("y", "um", values).into();
    message(series(&[]), "“y” holds 0 values for 3 points in time");
    message(series(&[]), "no data");
    message(series(&[1.0, 2.0]), "only the first 2 are drawn");
    message(series(&[f64::NAN; 3]), "none of its 3 samples is a finite number");
    message(series(&[1.0, f64::INFINITY, 3.0]), "1 of 3 samples are not finite numbers");
    message(series(&[4.0; 3]), "“y” is constant: 4 µm");
    message(
        TimeSeries::new("t", &[0.0, 2.0, 1.0]).measured("y", "um", &[1.0, 2.0, 3.0]).into(),
        "The time does not increase at sample 3",
    );
    message(
        TimeSeries::new("t", &time)
            .measured("y", "um", &[1.0, 2.0, 3.0])
            .marker(f64::NAN, "m")
            .into(),
        "The mark “m” is not drawn",
    );
    message(
        Spectrum::new("s", Axis::new("a", "um"))
            .trace(Role::Other, "y", &[0.0, 1.0, 2.0], &[1.0, -1.0, 1.0])
            .into(),
        "1 of 2 lines are not drawn",
    );
    message(TimeSeries::new("nothing", &[]).into(), "no data");
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::with_cases(256) })]

    #[test]
    fn no_data_panics_and_json_reads_back(
        values in prop::collection::vec(
            prop_oneof![
                5 => -1e3..1e3,
                1 => Just(f64::NAN),
                1 => Just(f64::NEG_INFINITY),
                1 => Just(0.0),
                1 => any::<f64>(),
            ],
            0..40,
        ),
    ) {
        let report = with_figures(every_figure("y", "um", &values));
        let page = report.to_html().unwrap();
        // Not in the packed data, whose base 64 holds any three letters.
        let data = "<script type=\"application/json\"";
        let parts = page.split("<script>").next().unwrap().split(data);
        let drawn: String =
            parts.map(|part| part.split_once("</script>").map_or(part, |(_, rest)| rest)).collect();
        prop_assert!(!drawn.contains("NaN") && !drawn.contains("inf "), "a coordinate is not a number");
        let json = report.to_json().unwrap();
        let again = Report::from_json(&json).unwrap();
        prop_assert_eq!(again.to_json().unwrap(), json);
        prop_assert_eq!(again.to_html().unwrap(), page);
    }
}

#[test]
#[allow(clippy::print_stdout)] // The figure is to be read in the test's output.
fn ten_signals_of_200_000_samples_stay_below_a_megabyte() {
    let n = 200_000;
    let time: Vec<f64> = (0..n).map(|i| f64::from(i) * 5e-5).collect();
    let mut random = SplitMix64::new(1);
    let mut noise = || random.uniform() - 0.5;
    let started = Instant::now();
    let figure = (0..10).fold(TimeSeries::new("Ten noisy signals", &time), |figure, k| {
        let values: Vec<f64> =
            time.iter().map(|t| (f64::from(k + 1) * t).sin() * 1.234_567 + noise()).collect();
        figure.other(format!("signal {k}"), if k < 5 { "um" } else { "V" }, &values)
    });
    let report = with_figures(vec![figure.into()]);
    let page = report.to_html().unwrap();
    println!("{} bytes in {:?}", page.len(), started.elapsed());
    assert!(page.len() <= 1_000_000, "{} bytes", page.len());
    assert!(report.to_json().unwrap().len() <= 1_000_000);
}

#[test]
fn equal_reports_give_equal_bytes() {
    let values: Vec<f64> = (0..5000).map(|i| f64::from(i % 77)).collect();
    let page = || with_figures(every_figure("y", "um", &values)).to_html().unwrap();
    assert_eq!(page(), page());
}

#[test]
fn another_schema_is_refused() {
    let json = report(Section::new("s")).to_json().unwrap().replace("report/1", "report/9");
    let error = Report::from_json(&json).unwrap_err();
    assert!(matches!(error, ReportError::Schema { .. }), "{error}");
    assert!(error.to_string().contains("piezoloop.report/9"), "{error}");
}
