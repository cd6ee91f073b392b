//! The page's types are the engine's: `src/generated/protocol.ts` is generated from them. `UPDATE_TYPES=1`
//! writes it again.

#![cfg(feature = "typescript")]

use std::any::TypeId;
use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write as _;
use std::path::Path;

use studio_engine::protocol::*;
use ts_rs::{Config, TS, TypeVisitor};

const FILE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../page/src/generated/protocol.ts");
const HEAD: &str = "\
// Made from the engine's own types by its test: UPDATE_TYPES=1 cargo test -p studio-engine --test types
//
// A number that is not finite comes as null, also where the type says `number`.

";

/// Every named type and its declaration.
struct Declarations {
    config: Config,
    seen: BTreeSet<TypeId>,
    by_name: BTreeMap<String, String>,
}

impl TypeVisitor for Declarations {
    fn visit<T: TS + 'static + ?Sized>(&mut self) {
        if !self.seen.insert(TypeId::of::<T>()) {
            return;
        }
        if T::output_path().is_some() {
            let name = T::ident(&self.config);
            let text = T::docs().unwrap_or_default() + "export " + &T::decl(&self.config);
            let other = self.by_name.insert(name.clone(), text.clone());
            assert!(other.is_none_or(|other| other == text), "two types of the name {name}");
        }
        T::visit_dependencies(self);
        T::visit_generics(self);
    }
}

fn written() -> String {
    let config = Config::new().with_large_int("number");
    let mut declarations = Declarations { config, seen: BTreeSet::new(), by_name: BTreeMap::new() };
    macro_rules! visit {
        ($($kind:ty),*) => { $(declarations.visit::<$kind>();)* };
    }
    visit!(
        OpenRequest,
        SamplesRequest,
        OpenSampleRequest,
        FlightRequest,
        CloseRequest,
        PresetsRequest,
        ModelRequest,
        EffectsRequest,
        SeriesRequest,
        CompareRequest,
        ScatterRequest,
        CorrelationRequest,
        DiagnoseRequest,
        PlanRequest,
        FormulaRequest,
        DiscoverRequest,
        AddRequest,
        LadderRequest,
        ExportRequest,
        Opened,
        Sample,
        Closed,
        Preset,
        ModelFacts,
        EffectGuide,
        Series,
        Ribbons,
        Paired,
        Correlated,
        Compared,
        Diagnosed,
        Planned,
        FormulaChecked,
        Discovered,
        Added,
        Exported,
        analysis::learn::Ladder
    );
    let mut text = HEAD.to_owned();
    for declaration in declarations.by_name.values() {
        let _ = writeln!(text, "{declaration}\n");
    }
    text += "/** Every request by its name, with its argument and its answer. */\nexport interface Calls {\n";
    for (name, request, answer) in REQUESTS {
        assert!(declarations.by_name.contains_key(*request), "{request} is not declared");
        let _ = writeln!(text, "  {name}: {{ of: {request}; answer: {answer} }};");
    }
    text + "}\n"
}

#[test]
fn the_pages_types_are_the_engines() {
    let written = written();
    if std::env::var_os("UPDATE_TYPES").is_some() {
        std::fs::create_dir_all(Path::new(FILE).parent().unwrap()).unwrap();
        std::fs::write(FILE, &written).unwrap();
    }
    let found = std::fs::read_to_string(FILE).unwrap_or_default();
    assert!(
        found == written,
        "{FILE} is stale: UPDATE_TYPES=1 cargo test -p studio-engine --test types writes it anew"
    );
}
